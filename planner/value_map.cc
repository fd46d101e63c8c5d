#include "planner/value_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn::planner {

ValueMap MakeValueMap(const World& world, int across) {
  ValueMap map;
  const Vector3d size = world.bounds.size();
  map.cell = std::max(size.x(), size.y()) / across;
  map.columns = static_cast<int>(std::ceil(size.x() / map.cell - 1e-9));
  map.rows = static_cast<int>(std::ceil(size.y() / map.cell - 1e-9));
  map.values.assign(static_cast<size_t>(map.columns) * static_cast<size_t>(map.rows),
                    std::numeric_limits<float>::quiet_NaN());
  return map;
}

ValueMap MapCosts(const World& world, const Roadmap& roadmap, const CostTable& table, int across) {
  ValueMap map = MakeValueMap(world, across);
  map.label = "cost-to-go [m]";
  const auto cell = [&](double coordinate, double low, int count) {
    return std::clamp(static_cast<int>((coordinate - low) / map.cell), 0, count - 1);
  };
  for (int v = 0; v < roadmap.num_places(); ++v) {
    if (!std::isfinite(table.cost[v])) continue;
    const Vector3d p = roadmap.position(v);
    const int row = cell(p.y(), world.bounds.min.y(), map.rows),
              column = cell(p.x(), world.bounds.min.x(), map.columns);
    float& value = map.values[static_cast<size_t>(row) * map.columns + column];
    value = std::isnan(value) ? table.cost[v] : std::min(value, table.cost[v]);
  }
  return map;
}

Vector3d CellCenter(const World& world, const ValueMap& map, int row, int column) {
  return {world.bounds.min.x() + (column + 0.5) * map.cell, world.bounds.min.y() + (row + 0.5) * map.cell, 0};
}

World Slice(const World& world, double z) {
  World slice = world;
  slice.dimension = 2;
  const auto stands = [z](const Box& box) { return box.min.z() <= z && z <= box.max.z(); };
  std::erase_if(slice.boxes, [&](const Box& box) { return !stands(box); });
  std::erase_if(slice.doors, [&](const Box& door) { return !stands(door); });
  std::erase_if(slice.cylinders, [z](const Cylinder& c) { return z < c.base.z() || c.base.z() + c.height < z; });
  for (Box* region : {&slice.start, &slice.goal}) {
    if (!stands(*region)) *region = Box();
  }
  return slice;
}

}  // namespace cairn::planner
