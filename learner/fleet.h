#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/messages.h"
#include "common/bus/reliable_stream.h"
#include "common/core/clock.h"
#include "learner/coordinator_state.h"

namespace cairn::learner {

/// What the learner knows of one actor process.
struct ActorRecord {
  int32_t actor_id = 0;
  int64_t session = 0;
  int32_t generation = 0;
  int64_t assignment = 0;  ///< number of its newest assignment; changes only with its vehicles
  bool joined = true;      ///< false: known from a checkpoint, not heard of since
  bool leaving = false;
  ReliableReceiver<Experience> stream;
  ActorStatus status;  ///< newest
  TimePoint last_heard{};
  TimePoint welcomed{};  ///< when its assignment was last sent
  int64_t echo_us = 0;
  int64_t unannounced_bytes = 0;  ///< received since the last control frame
  int64_t durable = 0;            ///< stream position that a checkpoint holds
  int64_t accepted = 0;           ///< transitions accepted from this session
  int64_t credit = 0;             ///< ASYNC: transitions it may have made in all
  int64_t credit_turn = 0;        ///< ASYNC: in which distribution it last got some

  /// It has acted on its newest assignment, and what it had made before has come in.
  bool settled() const { return status.assignment >= assignment && stream.received() >= status.last_sequence; }
};

/// What the learner knows of one training vehicle. `environment` is what its next owner goes on with; it is gone with
/// the first segment after it.
struct VehicleRecord : VehicleState {
  int32_t heir = -1;  ///< actor that gets it as soon as its owner has let go of it; −1: it stays
};

/// Who takes part, who rolls out which vehicle, and the accounting of every transition by content: nothing twice,
/// nothing missing. Plain bookkeeping; the Coordinator locks around it.
class Fleet {
 public:
  /// A run starts with `num_actors` processes that share `num_vehicles`: actor i has the slice [i V / N, (i + 1) V /
  /// N). Later others may join and any may leave.
  Fleet(int num_actors, int num_vehicles, uint64_t experiment_hash, int observation_size, std::string git_revision);

  /// Whether the hello is of our revision, experiment and shapes.
  bool Compatible(const Hello& hello) const { return Differences(hello).empty(); }

  /// Judges a request to join; on kAccepted the session holds its id from now on. `now` tells living holders.
  Welcome Join(const Hello& hello, TimePoint now);

  /// The record of a session that has joined; nullptr for others.
  ActorRecord* Find(int64_t session);

  /// Whether the segment continues its vehicle's trajectory exactly, comes from the vehicle's owner and has sane
  /// numbers.
  enum class Verdict { kSound, kForeign, kDuplicate, kGap, kNotFinite };
  Verdict Judge(const ActorRecord& actor, const Segment& segment) const;

  /// Takes a sound segment into the books.
  void Accept(const Segment& segment);

  /// A diverged episode is over though its last segment said that it goes on.
  void CloseDiverged(const ActorRecord& actor, const EpisodeResult& episode);

  /// The functions below return the sessions whose assignment changed.

  /// The run starts with who is here: a session of a checkpoint that did not come back loses its vehicles, and from now
  /// on a join is a disturbance.
  std::vector<int64_t> Start();

  /// Gives vehicles of those that have most to an actor that has joined a running job.
  std::vector<int64_t> Share(int32_t actor_id);

  /// An actor wants to end: others shall have its vehicles. Nothing happens when there is no other.
  std::vector<int64_t> Leave(int32_t actor_id);

  /// Hands vehicles that their owners have let go of to their heirs.
  std::vector<int64_t> Settle();

  /// Whether somebody else is here who could take an actor's vehicles over.
  bool HasOther(int32_t actor_id) const;

  /// Forgets an actor that is gone for good and gives its vehicles to the others; nothing happens without HasOther.
  std::vector<int64_t> Reassign(int32_t actor_id);

  /// Whether an actor that is leaving has nothing left here, so that it can be forgotten.
  bool Gone(const ActorRecord& actor) const;
  void Forget(int32_t actor_id) { actors_.erase(actor_id); }

  /// The current assignment of a session, as sent to it.
  Welcome Assignment(const ActorRecord& actor) const;

  /// The books of a run that goes on. To be called before anyone joins.
  void Restore(const CoordinatorState& state);

  const std::map<int32_t, ActorRecord>& actors() const { return actors_; }
  std::map<int32_t, ActorRecord>& actors() { return actors_; }
  const std::vector<VehicleRecord>& vehicles() const { return vehicles_; }
  int num_joined() const;
  bool complete() const { return num_joined() >= num_actors_; }
  bool started() const { return started_; }
  /// True once an actor was replaced or its vehicles were moved: the run is no longer reproducible.
  bool disturbed() const { return disturbed_; }

  void set_incarnation(int64_t incarnation) { incarnation_ = incarnation; }

 private:
  std::string Differences(const Hello& hello) const;
  Welcome Refuse(const Hello& hello, Welcome::Status status, std::string reason) const;
  int HomeActor(int vehicle) const;
  int Load(int32_t actor_id) const;
  int32_t LeastLoadedId(int32_t except) const;
  ActorRecord* LeastLoaded(int32_t except);
  void Give(VehicleRecord* vehicle, ActorRecord* actor, std::vector<int64_t>* changed);
  void Renumber(ActorRecord* actor, std::vector<int64_t>* changed);

  int num_actors_;
  uint64_t experiment_hash_;
  int observation_size_;
  std::string git_revision_;
  int64_t incarnation_ = 0;
  int64_t assignment_ = 0;
  bool started_ = false;
  bool disturbed_ = false;
  std::map<int32_t, ActorRecord> actors_;  // by actor id
  std::vector<VehicleRecord> vehicles_;
};

}  // namespace cairn::learner
