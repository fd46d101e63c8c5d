#pragma once

#include <cstdint>
#include <vector>

#include "common/roadmap/roadmap.h"
#include "planner/builders/point_tree.h"

namespace cairn::planner {

/// The roadmap of a graph in the making, over the first `dimension` coordinates: `neighbors` per vertex, each edge both
/// ways, in any order; ascending in the roadmap.
Roadmap ToRoadmap(int dimension, const PointTree& vertices, const std::vector<std::vector<int32_t>>& neighbors);

}  // namespace cairn::planner
