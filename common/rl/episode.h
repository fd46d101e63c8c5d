#pragma once

#include <cstdint>

namespace cairn {

enum class Outcome : int8_t { kRunning = 0, kGoal = 1, kCollision = 2, kTimeout = 3, kDiverged = 4 };

/// Lower-case word for files and pictures: "goal", "collision", "timeout", "diverged", "running".
const char* OutcomeName(Outcome outcome);

/// Which starts an episode came from. Only kTraining episodes enter replay.
enum class StartSet : int8_t { kTraining = 0, kConsumption = 1, kValidation = 2, kTest = 3 };

/// One finished episode.
struct EpisodeResult {
  StartSet set = StartSet::kTraining;
  int32_t vehicle = 0;  ///< training: the vehicle; evaluation: the start's index within its set
  int32_t episode = 0;  ///< training: the vehicle's episode number; evaluation: the evaluation's id
  int32_t steps = 0;
  Outcome outcome = Outcome::kRunning;
  int64_t policy_version = 0;
  float episode_return = 0;    ///< undiscounted sum of rewards
  float duration = 0;          ///< simulated time [s]; an event ends it within a control step
  float path_length = 0;       ///< driven by the vehicle's centre [m]
  float shortest_length = 0;   ///< cost-to-go of the start along the roadmap [m]
  float min_clearance = 0;     ///< smallest distance from footprint to obstacles [m]
  float mean_jerk = 0;         ///< mean |d²v/dt²| at control steps [m/s³]
  int32_t filtered_steps = 0;  ///< control steps in which the safety filter changed a command
};

}  // namespace cairn
