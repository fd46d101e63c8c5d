#pragma once

#include <algorithm>

#include "common/core/random.h"
#include "common/world/signed_distance.h"
#include "common/world/world.h"

namespace cairn::planner {

/// Two rooms of 1 m × 1 m (× 0.5 m) joined by a door of 0.2 m in the wall x = 1 … 1.05, a pillar in each.
inline World TwoRooms(int dimension) {
  World world;
  world.dimension = dimension;
  const double top = dimension == 3 ? 0.5 : 0;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(2, 1, top)};
  world.boxes = {{Vector3d(1, 0, 0), Vector3d(1.05, 0.4, top)}, {Vector3d(1, 0.6, 0), Vector3d(1.05, 1, top)}};
  world.cylinders = {{Vector3d(0.5, 0.5, 0), 0.1, 0.3}, {Vector3d(1.5, 0.3, 0.2), 0.06, 0.3}};
  world.start = {Vector3d(0, 0, 0), Vector3d(0.3, 0.3, top)};
  world.goal = {Vector3d(1.7, 0.7, 0), Vector3d(2, 1, top)};
  return world;
}

inline Vector3d DrawIn(const World& world, RandomStream& random) {
  Vector3d p = Vector3d::Zero();
  for (int k = 0; k < world.dimension; ++k) p[k] = random.Uniform(world.bounds.min[k], world.bounds.max[k]);
  return p;
}

/// Smallest distance to an obstacle along a–b, at `steps` + 1 points: at most |b − a| / (2 steps) too large.
inline double LeastDistance(const World& world, const Vector3d& a, const Vector3d& b, int steps = 100) {
  double least = 1e300;
  for (int i = 0; i <= steps; ++i) least = std::min(least, SignedDistance(world, a + (b - a) * (1.0 * i / steps)));
  return least;
}

}  // namespace cairn::planner
