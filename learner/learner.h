#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/config/experiment.h"
#include "common/nn/policy.h"
#include "common/rl/audit_log.h"
#include "learner/algorithms/algorithm.h"
#include "learner/coordinator.h"
#include "learner/evaluation_schedule.h"
#include "learner/replay/replay_buffer.h"
#include "learner/run_report.h"

namespace cairn::learner {

struct LearnerOptions {
  std::string run_dir;    ///< empty: nothing is written
  int num_actors = 1;     ///< to wait for at the start
  int64_t launch_us = 0;  ///< MonotonicUs() when the user started the run
  uint64_t experiment_hash = 0;
};

/// The update thread: receives what the actors made, trains on it, publishes policies, asks for evaluations, counts.
/// Only it counts env_steps (DESIGN 12).
class Learner {
 public:
  Learner(Bus* bus, const Experiment& experiment, const LearnerOptions& options);

  /// Trains to the end of the run and tests. Returns normally also when stopped; `completed()` tells.
  /// Throws Error on a non-finite update and when a file cannot be written.
  void Run();

  /// Ends Run soon, from any thread: the policy so far is saved, the summary says completed: false.
  void RequestStop() { coordinator_.Stop(); }

  bool completed() const { return completed_; }

 private:
  void RunLockstep();
  void RunAsync();
  void GrantNextRound();
  void Insert(const Harvest& harvest);
  /// Makes the updates that the env steps so far pay for, at most `limit`; returns how many it made.
  int64_t Train(int64_t limit);
  int64_t UpdatesDue() const;
  void Publish();
  void FinishRun();
  RunCounters Counters(const char* phase);
  PolicySnapshot Snapshot() const;
  void SaveSnapshot(const PolicySnapshot& snapshot, const std::string& name) const;
  double progress() const { return static_cast<double>(env_steps_) / static_cast<double>(experiment_.total_env_steps); }

  Bus* bus_;
  const Experiment& experiment_;
  const LearnerOptions options_;
  const PolicyShape shape_;
  Coordinator coordinator_;
  ReplayBuffer replay_;
  std::unique_ptr<Algorithm> algorithm_;
  RunReport report_;
  EvaluationSchedule evaluation_;
  AuditLog audit_;
  int64_t env_steps_ = 0;  // inserted
  int64_t granted_ = 0;    // LOCKSTEP: granted, inserted or not
  int64_t updates_ = 0;
  bool completed_ = false;
};

}  // namespace cairn::learner
