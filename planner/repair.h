#pragma once

#include <vector>

#include "common/roadmap/roadmap.h"
#include "common/world/world.h"

namespace cairn::planner {

/// Cuts the edges along which a sphere (a disc in the plane) of `radius` [m] ≥ 0 would touch one of `marks`, obstacles
/// that the map did not know of: a shut door, or a point of contact as a box without extent. The lengths of cut edges
/// become kUnreachable, which no cost table takes; vertices, edges and Roadmap::Hash stay, so whoever has the positions
/// needs only the new table: ComputeCostTable of the same roadmap. Returns how many edges were cut.
int BlockEdges(const std::vector<Box>& marks, double radius, Roadmap* roadmap);

}  // namespace cairn::planner
