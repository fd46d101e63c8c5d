#pragma once

#include <vector>

#include "common/roadmap/roadmap.h"
#include "common/world/world.h"

namespace cairn::planner {

/// A way along the roadmap to the goal region.
struct Path {
  std::vector<Vector3d>
      points;         ///< vertices in order, W [m], the last moved to the goal region's border; empty: no way
  double length = 0;  ///< [m]
};

/// The shortest way from a vertex; empty when the goal cannot be reached from it.
Path PathFrom(const Roadmap& roadmap, const CostTable& table, int vertex);

/// The shortest way from the start region: from the vertex nearest to its centre, of those inside it if there are any,
/// with finite cost. Empty when no vertex has one.
Path OptimalPath(const World& world, const Roadmap& roadmap, const CostTable& table);

}  // namespace cairn::planner
