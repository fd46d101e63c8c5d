#pragma once

#include <string>
#include <vector>

#include "common/roadmap/roadmap.h"
#include "common/world/world.h"

namespace cairn::planner {

/// A number for each cell of a square grid over a plane world, for pictures.
struct ValueMap {
  double cell = 0;            ///< side of a cell [m]; the grid's lower left corner is the bounds'
  int columns = 0;            ///< along x
  int rows = 0;               ///< along y
  std::vector<float> values;  ///< [rows × columns], row by row from below; NaN: nothing to draw
  std::string label;          ///< of the colour bar
};

/// A grid without values, `across` cells along the longer side of the bounds.
ValueMap MakeValueMap(const World& world, int across);

/// The smallest finite cost-to-go [m] of the vertices in each cell of such a grid: what is left to draw of a roadmap
/// with more vertices than a picture has points.
ValueMap MapCosts(const World& world, const Roadmap& roadmap, const CostTable& table, int across);

/// Centre of a cell; z is 0.
Vector3d CellCenter(const World& world, const ValueMap& map, int row, int column);

/// The plane world that a horizontal cut through a world in space shows: what stands at height z [m]. Start and goal
/// are empty boxes where they are not at that height.
World Slice(const World& world, double z);

}  // namespace cairn::planner
