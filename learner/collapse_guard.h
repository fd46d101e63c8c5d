#pragma once

#include <cstdint>
#include <string>

#include "common/config/experiment.h"
#include "learner/algorithms/algorithm.h"
#include "learner/checkpoint/run_state.h"
#include "learner/evaluation_schedule.h"

namespace cairn::learner {

/// Asks for evaluations, says when a policy has learnt to stand still or has lost a task that it had solved, and with
/// learner.on_collapse: REVERT_TO_BEST goes back to the networks of the best validated policy. In LOCKSTEP that does
/// not depend on when results come in: those of one check are awaited at the next.
class CollapseGuard {
 public:
  CollapseGuard(const Experiment& experiment, EvaluationSchedule* evaluation, Algorithm* algorithm);

  /// To be called after each training phase, before its policy is published: goes back when the task is lost.
  void BeforePublish(int64_t env_steps);

  /// To be called with the policy just published, of which nothing has changed since.
  void Visit(int64_t env_steps, int64_t version);

  /// What is to be said of a collapse, or else of hovering; empty: nothing.
  const std::string& warning() const { return collapse_.empty() ? hovering_ : collapse_; }

  const NetworksByVersion& candidates() const { return candidates_; }
  void Restore(NetworksByVersion candidates) { candidates_ = std::move(candidates); }

 private:
  void OnCollapse(int64_t env_steps);
  void OnHovering(int64_t env_steps);

  const int consumption_starts_;
  const int collapse_checks_;
  const bool reverts_;
  const bool waits_;
  EvaluationSchedule* evaluation_;
  Algorithm* algorithm_;
  NetworksByVersion candidates_;  // the best and those under evaluation
  std::string collapse_;          // said until the task is solved again
  std::string hovering_;          // said until a check is in that does not hover
};

}  // namespace cairn::learner
