#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "learner/coordinator_state.h"
#include "learner/evaluation_queue.h"

namespace cairn::learner {

/// Where the evaluation schedule stands.
struct EvaluationState {
  struct Asked {
    EvaluationRequest request;
    PolicySnapshot policy;
  };
  int64_t next_check = 0;
  int64_t num_checks = 0;
  int64_t consumption_env_steps = -1;
  double consumption_wall_s = -1;
  int later_checks = 0;
  int later_solved = 0;
  int last_solved = -1;
  int failed_checks = 0;   ///< checks in a row, after the first solved one, with less than half of the starts solved
  bool collapsed = false;  ///< seen, not yet acted on
  std::optional<PolicySnapshot> best;
  double best_success = -1;
  double best_time = 0;      ///< minus its mean time to the goal [s]
  std::vector<Asked> asked;  ///< not answered yet, in order
};

}  // namespace cairn::learner
