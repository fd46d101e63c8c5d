#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "actors/course.h"
#include "actors/evaluation.h"
#include "actors/experience_batcher.h"
#include "actors/goal_tables.h"
#include "actors/policy_store.h"
#include "actors/rollout.h"
#include "common/bus/bus.h"
#include "common/bus/reliable_stream.h"
#include "common/bus/state_assembler.h"
#include "common/bus/table_client.h"
#include "common/config/experiment.h"
#include "common/rl/audit_log.h"

namespace cairn::actors {

struct ActorIdentity {
  int actor_id = 0;
  int generation = 0;
  uint64_t experiment_hash = 0;
};

/// The actor process: joins the learner, pulls the cost table from the planner, then rolls out what the control frame
/// grants (LOCKSTEP rounds or ASYNC credit) and evaluates what it asks, until the learner says finished. One thread;
/// state, not events, drives it, so any lost datagram only costs time.
class Actor {
 public:
  /// `bus` must outlive the actor. Throws UsageError as Scene does.
  Actor(Bus* bus, const Experiment& experiment, const ActorIdentity& identity);

  /// kFinished: the run is, or this actor has left it. kStartOver: this session cannot go on, since the learner does
  /// not know it (any more) or, in LOCKSTEP, is a new one; an Actor on a Bus with another session can.
  enum class End { kFinished, kStartOver };

  /// Throws UsageError when the learner refuses this process: another revision, experiment, or an id that is taken;
  /// starting it again would not help.
  End Run();

  /// Leaves the running job, from any thread: others get the vehicles, nothing that was made is lost.
  void RequestLeave();

 private:
  // What comes in.
  void Subscribe();
  void OnWelcome(const Welcome& welcome);
  void OnControl(Control control);
  void OnState(const AssignedState& state);
  void OnNewLearner(int64_t incarnation);
  void GoOn(const Welcome& welcome);
  // What it does; each returns whether there was something to do.
  bool Join(TimePoint now);
  bool Left(TimePoint now);
  void CheckMembership(TimePoint now);
  Duration StatusInterval() const;
  Duration Wait(TimePoint now) const;
  bool ReceiveTable();
  bool TakeAssignment();
  std::vector<SavedVehicle> SaveVehicles() const;
  bool RollRounds();
  bool RollRound(const Control::Round& round);
  bool RollCredit();
  bool RollStep();
  bool Evaluate();
  bool BeginEvaluation();
  void FinishEvaluation();
  // What goes out.
  void SendExperience(bool with_states = false);
  void SendStatus(TimePoint now, Duration interval);
  void SendTelemetry(TimePoint now);

  /// Sets the policy to a version; asks for it and returns false when it is not here yet.
  bool UsePolicy(int64_t version);
  RolloutContext Context(bool warm_up);
  bool finished() const { return control_ && control_->phase == Control::Phase::kFinished; }
  bool running() const { return control_ && control_->phase == Control::Phase::kRunning && has_table_; }

  Bus* bus_;
  const Experiment& experiment_;
  const ActorIdentity identity_;
  const int observation_size_;
  const int action_size_;
  std::shared_ptr<Scene> scene_;
  TableClient tables_;
  GoalTables goal_tables_;  // goals = ANY
  std::shared_ptr<Course> course_;
  PolicyStore policies_;
  Policy policy_;
  Rollout rollout_;
  ReliableSender stream_;
  AuditLog audit_;

  std::atomic<bool> leaving_{false};
  int64_t incarnation_ = 0;         // of the learner: the highest heard of
  std::optional<Control> control_;  // its newest frame, without actors
  std::optional<Control::Actor> me_;
  int64_t me_number_ = 0;      // of the frame that it is from
  int64_t me_evaluation_ = 0;  // of which evaluation that frame told the share
  TimePoint me_seen_{};
  std::optional<Welcome> welcome_;  // newest
  bool joined_ = false;             // with this learner
  bool start_over_ = false;
  StateAssembler states_;  // of the newest assignment
  std::string refusal_;
  bool has_table_ = false;
  int64_t assignment_done_ = -1;
  int64_t round_done_ = 0;
  int64_t evaluation_done_ = 0;
  size_t next_vehicle_ = 0;  // ASYNC: whose turn it is when credit is short
  int64_t policy_in_use_ = -1;
  int64_t policy_incarnation_ = 0;  // whose version that is
  int64_t wanted_policy_version_ = -1;
  // The share of an evaluation that runs here, in turns with what comes in.
  struct RunningEvaluation {
    int64_t id;
    int64_t version;
    EvaluationBatch batch;
  };
  std::optional<RunningEvaluation> evaluation_;
  std::vector<EpisodeResult> evaluation_results_;
  int64_t eval_steps_ = 0;
  TimePoint next_hello_{};
  TimePoint id_taken_since_{};
  TimePoint leave_deadline_ = TimePoint::max();
  Duration waited_{};  // with nothing to do, since it joined
  TimePoint last_status_{};
  TimePoint open_since_{};  // ASYNC: when the oldest step was made that has not left
  int64_t flushed_steps_ = 0;
  TimePoint last_telemetry_{};
  int64_t telemetry_env_steps_ = 0;
  double busy_s_ = 0;  // since the last telemetry
};

}  // namespace cairn::actors
