#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/core/hash.h"
#include "common/world/world.h"

namespace cairn {

/// A goal region in one of the experiment's worlds, and the obstacles there that the planner does not know: what names
/// a cost table that nobody has made yet.
struct WorldGoal {
  /// More marks make no request.
  static constexpr size_t kMaxMarks = 64;

  uint64_t world_seed = 0;
  std::array<double, 3> min{}, max{};  ///< in W [m]; equal: a point
  std::vector<float> marks;            ///< [3 × number], middles of marked obstacles in W [m]

  WorldGoal() = default;
  WorldGoal(uint64_t seed, const Box& goal, std::vector<float> m = {})
      : world_seed(seed),
        min{goal.min.x(), goal.min.y(), goal.min.z()},
        max{goal.max.x(), goal.max.y(), goal.max.z()},
        marks(std::move(m)) {}

  Box box() const { return {Vector3d(min[0], min[1], min[2]), Vector3d(max[0], max[1], max[2])}; }
  bool operator==(const WorldGoal&) const = default;
};

struct WorldGoalHash {
  size_t operator()(const WorldGoal& goal) const {
    uint64_t hash = ContentHash(goal.min.data(), sizeof(goal.min), goal.world_seed);
    hash = ContentHash(goal.max.data(), sizeof(goal.max), hash);
    return ContentHash(goal.marks.data(), goal.marks.size() * sizeof(float), hash);
  }
};

}  // namespace cairn
