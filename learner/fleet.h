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
  ReliableReceiver stream;
  TimePoint last_heard{};
  TimePoint welcomed{};  ///< when its assignment was last sent
  int64_t echo_utime = 0;
  int64_t accepted = 0;  ///< transitions accepted from this session
  int64_t credit = 0;    ///< ASYNC: transitions it may have made in all
  int64_t wanted_policy_version = -1;
};

/// What the learner knows of one training vehicle. `environment` is what its next owner goes on with; it is gone with
/// the first segment after it.
struct VehicleRecord : VehicleState {
  int32_t owner = -1;  ///< actor id; −1: nobody
};

/// Who takes part, who rolls out which vehicle, and the accounting of every transition by content: nothing twice,
/// nothing missing. Plain bookkeeping; the Coordinator locks around it.
class Fleet {
 public:
  /// `num_actors` processes share `num_vehicles`: actor i has the slice [i V / N, (i + 1) V / N).
  Fleet(int num_actors, int num_vehicles, uint64_t experiment_hash, int observation_size, std::string git_revision);

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

  /// Gives the vehicles of an actor that is gone for good to the others; returns the sessions whose assignment changed.
  std::vector<int64_t> Reassign(int32_t actor_id);

  /// The current assignment of a session, as sent to it.
  Welcome Assignment(const ActorRecord& actor) const;

  /// The books of a run that goes on. To be called before anyone joins.
  void Restore(const CoordinatorState& state);

  const std::map<int32_t, ActorRecord>& actors() const { return actors_; }
  std::map<int32_t, ActorRecord>& actors() { return actors_; }
  const std::vector<VehicleRecord>& vehicles() const { return vehicles_; }
  int num_actors() const { return num_actors_; }
  bool complete() const { return static_cast<int>(actors_.size()) == num_actors_; }
  /// True once an actor was replaced or its vehicles were moved: the run is no longer reproducible.
  bool disturbed() const { return disturbed_; }

  void set_incarnation(int64_t incarnation) { incarnation_ = incarnation; }
  /// Called when the first data or grant is out: a join after that is a disturbance.
  void set_started() { started_ = true; }

 private:
  std::string Differences(const Hello& hello) const;
  int HomeActor(int vehicle) const;

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
