#pragma once

#include <vector>

#include "planner/collision/free_space.h"

namespace cairn::planner {

/// Where shortest ways bend: free points just outside of the obstacles' edges (corners in the plane) as the robot's
/// radius rounds them, from which the goal can be reached. Two to a right angle, where the tangents of the arc meet, so
/// that ways around it are 5 % of the arc too long at most; along edges in space every eta / 2 [m]. None is nearer than
/// eta / 5 to another, or farther apart if they would be more than `max_count`. In random order, the same each time.
std::vector<Vector3d> FindBends(const FreeSpace& space, double eta, size_t max_count);

}  // namespace cairn::planner
