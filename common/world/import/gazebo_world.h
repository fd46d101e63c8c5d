#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/world/import/cell_grid.h"
#include "common/world/world.h"

namespace cairn {

/// Obstacles of a Gazebo world, as the BARN data set has them.
struct GazeboObstacles {
  std::vector<Cylinder> cylinders;
  std::vector<Box> boxes;
};

/// Upright cylinders and boxes that stand along the axes, from the collision shapes of all models of an SDF .world
/// file; a pose in <state> takes the place of the model's own. Planes are ground. With a slice of heights [m], only
/// what reaches into it. Throws UsageError naming file, model and rule for every shape that it cannot keep exactly.
GazeboObstacles ReadGazeboWorld(std::string_view text, const std::string& file, const std::optional<Slice>& slice);

}  // namespace cairn
