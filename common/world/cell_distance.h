#pragma once

#include <vector>

#include "common/world/world.h"

namespace cairn {

/// Signed distances [m] at the nodes bounds.min + resolution · (x, y, z), in the order [z][y][x], to the obstacles and
/// to the outside of the bounds; negative inside the obstacles' union: minus the distance to free space. Exact (to
/// float) and linear in the nodes and boxes (Felzenszwalb and Huttenlocher, Distance Transforms of Sampled Functions,
/// 2012), but only for worlds of boxes whose edges, and the bounds, lie on nodes, as those of imported maps do: empty
/// for others.
std::vector<float> CellDistances(const World& world, double resolution, const Eigen::Vector3i& nodes);

}  // namespace cairn
