#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "common/bus/bus.h"
#include "common/bus/table_client.h"
#include "common/config/experiment.h"
#include "learner/control_writer.h"
#include "learner/coordinator_state.h"
#include "learner/credit_ledger.h"
#include "learner/evaluation_queue.h"
#include "learner/evaluator.h"
#include "learner/fleet.h"
#include "learner/harvest.h"
#include "learner/intake.h"
#include "learner/open_rounds.h"
#include "learner/policy_outbox.h"

namespace cairn::learner {

/// The learner's side of the conversation: a thread that receives hellos, statuses and experience, keeps the books
/// (Fleet), and announces rounds, credit, acknowledgements and evaluations in one aggregated control frame. The update
/// thread calls the public functions; all of them are thread-safe.
class Coordinator final : public Evaluator {
 public:
  /// `incarnation` is higher than that of any learner of this run before.
  Coordinator(Bus* bus, const Experiment& experiment, uint64_t experiment_hash, int num_actors, int64_t incarnation);
  ~Coordinator() override;
  Coordinator(const Coordinator&) = delete;
  Coordinator& operator=(const Coordinator&) = delete;

  /// Subscribes, checks the planes, starts the thread. Throws Error as Bus does.
  void Start();

  /// Blocks until all actors have joined and the planner's table is known, or Stop. False when stopped. A learner that
  /// follows another waits for missing actors no longer than it waits for silent ones.
  bool WaitForFleet();

  /// Ends waiting functions; they return false or nothing.
  void Stop();
  /// The same after a while, if nobody did it before.
  void StopWithin(Duration time);

  bool stopped() const override;

  /// Announces the end of the run to the actors (several times) and stops the thread.
  void Finish();

  /// Makes a policy known as the newest: sent once now and again to actors that ask. ASYNC actors use it at once,
  /// LOCKSTEP ones from the next granted round on.
  void PublishPolicy(int64_t version, std::span<const float> parameters);

  /// LOCKSTEP: every vehicle makes `steps` more steps with the newest published policy, the first `extra` vehicles one
  /// more. Rounds that are granted before the one before them is complete let no actor wait for another.
  /// With `save` its harvest has the vehicles' states, for a checkpoint. Returns the number of transitions; less than
  /// steps per vehicle when not all had made the same number, which rounds_level() tells.
  int64_t GrantRound(int steps, int extra, bool warm_up, bool save = false);

  /// ASYNC: the least time between two policies worth sending. Every actor wakes up for each, so it grows with their
  /// number: 20 ms for a few, 0.1 s for 64.
  Duration publish_interval() const;

  bool rounds_level() const;

  /// LOCKSTEP: rounds that are granted and not taken.
  int open_rounds() const;

  /// LOCKSTEP: the oldest granted round when it is complete, ordered by (vehicle, step), so that it does not depend on
  /// timing or on the number of actors. Nullopt when stopped.
  std::optional<Harvest> WaitRound();

  /// ASYNC: total transitions that may be made so far; never lower than before. Call it often: small amounts are not
  /// given at once, but when enough has gathered or after 50 ms.
  void SetAllowed(int64_t allowed, bool warm_up);

  /// ASYNC: what has come in since the last call, in order of arrival; waits up to `timeout` for something.
  Harvest Take(Duration timeout);

  void Evaluate(const EvaluationRequest& request, std::span<const float> parameters) override;
  std::vector<EvaluationReport> TakeEvaluations(bool wait) override;

  /// The books for a checkpoint. LOCKSTEP: at the end of the round `harvest`. ASYNC: with everything in them that has
  /// come in; `harvest` gets what of it was not taken yet.
  CoordinatorState State(Harvest* harvest);

  /// Actors keep what they have sent until SetDurable says that a checkpoint has it. Before Start.
  void KeepUntilDurable() { keeps_ = true; }
  void SetDurable(const std::vector<SessionState>& sessions);

  /// Goes on where another learner's State ended, after `env_steps`. Before Start.
  void Restore(const CoordinatorState& state, int64_t env_steps);

  CoordinatorCounters counters() const;
  TableInfo table_info() const;

 private:
  void Run(const std::stop_token& stop);
  void OnHello(const Hello& hello);
  void OnStatus(const ActorStatus& status);
  void OnExperience(Experience&& experience);
  // The functions below expect mutex_ to be held.
  bool FleetReady(TimePoint now) const;
  void SendWelcomes(const std::vector<int64_t>& sessions);
  void Retire(const ActorRecord& actor);
  CoordinatorCounters Counters() const;
  void SharesChanged();
  void SendWelcome(ActorRecord* actor, TimePoint now);
  void AnnounceEvaluation();
  void GiveUpSilentActors(TimePoint now);
  void KeepPolicy(int64_t version, std::span<const float> parameters);
  void SendControl(TimePoint now);
  void AnnounceIfDue(TimePoint now);
  Duration Interval(Duration least, Duration most) const;
  bool WaitingForActors() const;

  Bus* bus_;
  const Experiment& experiment_;
  const int observation_size_;
  TableClient tables_;

  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable changed_;
  Fleet fleet_;
  Control control_;
  CoordinatorCounters counters_;
  TableInfo table_info_;
  PolicyOutbox policies_;
  OpenRounds rounds_;
  EvaluationQueue evaluations_;
  Intake intake_;
  ControlWriter writer_;
  CreditLedger credit_;  // ASYNC
  bool keeps_ = false;
  TimePoint started_{};
  bool stopped_ = false;
  TimePoint stop_at_ = TimePoint::max();
  bool dirty_ = false;
  bool news_ = false;  // for whoever waits for changed_
  TimePoint last_control_{};
  std::jthread thread_;
};

}  // namespace cairn::learner
