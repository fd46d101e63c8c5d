#include "tests/testing/grid_roadmap.h"

#include <cmath>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

namespace cairn::testing {

Roadmap MakeGridRoadmap(const World& world, const DistanceField& field, double spacing, double radius) {
  const int columns = static_cast<int>(world.bounds.size().x() / spacing) + 1;
  const int rows = static_cast<int>(world.bounds.size().y() / spacing) + 1;
  const auto point = [&](int column, int row) -> Vector3d {
    return world.bounds.min + Vector3d((column + 0.5) * spacing, (row + 0.5) * spacing, 0);
  };
  Roadmap roadmap;
  std::vector<int> vertex(static_cast<size_t>(columns * rows), -1);
  std::vector<std::pair<int, int>> lattice;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Vector3d p = point(column, row);
      if (field.Distance(p) < radius) continue;
      vertex[static_cast<size_t>(row * columns + column)] = static_cast<int>(lattice.size());
      lattice.emplace_back(column, row);
      roadmap.positions.push_back(static_cast<float>(p.x()));
      roadmap.positions.push_back(static_cast<float>(p.y()));
    }
  }
  roadmap.offsets.push_back(0);
  for (const auto& [column, row] : lattice) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int x = column + dx, y = row + dy;
        if ((dx == 0 && dy == 0) || x < 0 || y < 0 || x >= columns || y >= rows) continue;
        const int neighbor = vertex[static_cast<size_t>(y * columns + x)];
        if (neighbor < 0 || !field.SegmentClear(point(column, row), point(x, y), radius)) continue;
        roadmap.neighbors.push_back(neighbor);
        roadmap.lengths.push_back(static_cast<float>(spacing * std::hypot(dx, dy)));
      }
    }
    roadmap.offsets.push_back(static_cast<int32_t>(roadmap.neighbors.size()));
  }
  return roadmap;
}

CostTable MakeCostTable(const Roadmap& roadmap, const World& world, const Box& goal) {
  const auto n = static_cast<size_t>(roadmap.num_vertices());
  CostTable table{roadmap.Hash(), goal, std::vector<float>(n, kUnreachable), std::vector<int32_t>(n, -1)};
  using Item = std::pair<float, int>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  for (int v = 0; v < roadmap.num_vertices(); ++v) {
    if (!world.Contains(goal, roadmap.position(v))) continue;
    table.cost[static_cast<size_t>(v)] = 0;
    queue.emplace(0.0f, v);
  }
  while (!queue.empty()) {
    const auto [cost, v] = queue.top();
    queue.pop();
    if (cost > table.cost[static_cast<size_t>(v)]) continue;
    for (int e = roadmap.offsets[static_cast<size_t>(v)]; e < roadmap.offsets[static_cast<size_t>(v) + 1]; ++e) {
      const auto u = static_cast<size_t>(roadmap.neighbors[static_cast<size_t>(e)]);
      const float through = cost + roadmap.lengths[static_cast<size_t>(e)];
      if (through >= table.cost[u]) continue;
      table.cost[u] = through;
      table.next_vertex[u] = v;
      queue.emplace(through, static_cast<int>(u));
    }
  }
  return table;
}

std::shared_ptr<const RoadmapLookup> MakeGridLookup(const World& world, const DistanceField& field, double spacing,
                                                    double radius, double r_ball) {
  const Roadmap roadmap = MakeGridRoadmap(world, field, spacing, radius);
  return std::make_shared<RoadmapLookup>(2, roadmap.positions, MakeCostTable(roadmap, world, world.goal), r_ball);
}

}  // namespace cairn::testing
