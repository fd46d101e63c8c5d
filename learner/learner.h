#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/config/experiment.h"
#include "common/nn/policy.h"
#include "common/rl/audit_log.h"
#include "learner/algorithms/algorithm.h"
#include "learner/checkpoint/checkpointer.h"
#include "learner/checkpoint/progress_file.h"
#include "learner/collapse_guard.h"
#include "learner/coordinator.h"
#include "learner/evaluation_schedule.h"
#include "learner/logged_experience.h"
#include "learner/replay/replay_buffer.h"
#include "learner/run_report.h"

namespace cairn::learner {

struct LearnerOptions {
  std::string run_dir;    ///< empty: nothing is written
  bool resume = false;    ///< go on from the newest checkpoint there, if there is one
  int num_actors = 1;     ///< to wait for at the start
  int64_t launch_us = 0;  ///< MonotonicUs() when the user started the run
  uint64_t experiment_hash = 0;
  std::string replay_log;  ///< LCM log whose experience is trained on, instead of what actors make; empty: none
  std::optional<RunKey> replay_key;  ///< with which that is sealed
};

/// The update thread: receives what the actors made, trains on it, publishes policies, asks for evaluations, counts.
/// Only it counts env_steps (DESIGN 12).
class Learner {
 public:
  Learner(Bus* bus, const Experiment& experiment, const LearnerOptions& options);

  /// Trains to the end of the run and tests. Returns normally also when stopped; `completed()` tells.
  /// Throws Error when too many updates in a row are not finite and when the summary cannot be written, UsageError when
  /// the run cannot be resumed or learner.init_from does not fit.
  void Run();

  /// Ends Run soon, from any thread: a checkpoint is written if that takes no more than 10 s, the policy so far is
  /// saved, the summary says completed: false.
  void RequestStop();

  bool completed() const { return completed_; }

 private:
  void Prepare();
  void Restore();
  void CheckTotal(const std::vector<RoundState>& open) const;
  void InitFrom(const std::string& run_dir);
  void StartRounds();
  void RunLockstep();
  void RunAsync();
  void RunFromLog();
  void GrantRounds();
  bool GrantNextRound();
  void Insert(const Harvest& harvest);
  /// Makes the updates that the env steps so far pay for, at most `limit`; returns how many it made.
  int64_t Train(int64_t limit);
  int64_t UpdatesDue() const;
  int64_t RolledBack() const;
  void Publish();
  void PublishAndEvaluate();
  void FinishRun();
  void SettleAndSave();
  bool CheckpointDue() const;
  void SaveRound(Harvest* round);
  RunState State(CoordinatorState coordinator);
  void Save(CoordinatorState coordinator);
  void NoteDurable();
  PolicyFile ToFile(const PolicySnapshot& snapshot) const;
  void WriteDiagnostic(const std::string& error);
  RunCounters Counters(const char* phase);
  PolicySnapshot Snapshot() const;
  std::string TrySave(const PolicySnapshot& snapshot, const std::string& name) const;
  double run_share() const {
    return static_cast<double>(env_steps_) / static_cast<double>(experiment_.total_env_steps);
  }

  Bus* bus_;
  const Experiment& experiment_;
  const LearnerOptions options_;
  const PolicyShape shape_;
  std::unique_ptr<ProgressFile> progress_;  // before the coordinator, which is told the incarnation
  Coordinator coordinator_;
  ReplayBuffer replay_;
  std::unique_ptr<Algorithm> algorithm_;
  RunReport report_;
  EvaluationSchedule evaluation_;
  CollapseGuard collapse_guard_;
  AuditLog audit_;
  int64_t env_steps_ = 0;  // inserted
  int64_t granted_ = 0;    // LOCKSTEP: granted, inserted or not
  int64_t updates_ = 0;
  int64_t rolled_back_ = 0;        // by this and earlier learners, if no actor has kept it
  int64_t lost_with_learner_ = 0;  // of these, made since the checkpoint that this learner began with
  std::unique_ptr<Checkpointer> checkpointer_;
  TimePoint last_checkpoint_{};
  bool saving_ = false;                                     // LOCKSTEP: a round that gives the vehicles' states is open
  std::map<int64_t, std::vector<SessionState>> undurable_;  // by env steps of checkpoints on their way to the disk
  std::unique_ptr<LoggedExperience> log_;                   // instead of the actors' experience
  bool log_ended_ = false;
  std::optional<RunState> resumed_;  // until the run has taken it up
  std::atomic<bool> stop_requested_{false};
  std::atomic<bool> training_{false};
  bool completed_ = false;
};

}  // namespace cairn::learner
