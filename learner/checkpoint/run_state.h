#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/nn/policy.h"
#include "learner/algorithms/state_array.h"
#include "learner/coordinator_state.h"
#include "learner/evaluation_state.h"

namespace cairn::learner {

/// A chunk of replay rows in a file of its own.
struct ReplayChunk {
  std::string file;
  int64_t first = 0;  ///< number of its first row since the run's start
  int32_t rows = 0;
  uint32_t crc32c = 0;
};

/// The replay buffer's rows [num_inserted − size, num_inserted), oldest first.
struct ReplayIndex {
  int64_t num_inserted = 0;
  int32_t row_floats = 0;
  std::vector<ReplayChunk> chunks;
};

/// Whole states of an Algorithm by policy version.
using NetworksByVersion = std::map<int64_t, std::vector<StateArray>>;

/// A learner between two rounds (LOCKSTEP) or two turns (ASYNC): everything that a new process needs to go on as if
/// nothing had happened (DESIGN 16).
struct RunState {
  /// What must agree for the rest to mean anything, as (option, value): another value is refused by name.
  std::vector<std::pair<std::string, std::string>> fields;
  std::string git_revision;
  int64_t env_steps = 0;
  int64_t updates = 0;
  int64_t granted = 0;  ///< LOCKSTEP: env steps granted so far, those of `rounds` included
  int64_t transitions_rolled_back = 0;
  double wall_s = 0;  ///< since the launch, interruptions left out
  int64_t episode_log_bytes = 0;
  std::vector<StateArray> algorithm;
  NetworksByVersion candidates;  ///< REVERT_TO_BEST: of the best policy and those under evaluation
  CoordinatorState coordinator;
  EvaluationState evaluation;
  ReplayIndex replay;
  /// Written beside for evaluation without a learner, as (file name, policy); not read back.
  std::vector<std::pair<std::string, PolicyFile>> policies;
};

}  // namespace cairn::learner
