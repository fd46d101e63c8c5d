#pragma once

#include <cstdint>
#include <vector>

namespace cairn {

/// How a segment of a trajectory ends.
enum class SegmentEnd : int8_t {
  kNone = 0,        ///< goes on in the next segment of the same vehicle and episode
  kTerminated = 1,  ///< collision or goal: no bootstrap
  kTruncated = 2,   ///< step limit: bootstrap from the last observation
  kCut = 3,         ///< table changed in mid-episode: bootstrap from the last observation, then go on
};

/// Consecutive steps of one vehicle in one episode under one policy version and one cost table (DESIGN: segments).
/// n actions and rewards, n + 1 observations; the last observation belongs to this segment's end.
struct Segment {
  int32_t vehicle = 0;
  int32_t episode = 0;
  int32_t first_step = 0;  ///< index within the episode of the first action
  SegmentEnd end = SegmentEnd::kNone;
  uint64_t table_hash = 0;
  int64_t policy_incarnation = 0;
  int64_t policy_version = 0;
  std::vector<float> observations;  ///< [(n + 1) × observation size], row per step
  std::vector<float> actions;       ///< [n × action size], the policy's, in [−1, 1]
  std::vector<float> rewards;       ///< [n]

  int num_steps() const { return static_cast<int>(rewards.size()); }
};

}  // namespace cairn
