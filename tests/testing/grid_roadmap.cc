#include "tests/testing/grid_roadmap.h"

#include <functional>
#include <queue>
#include <utility>
#include <vector>

namespace cairn::testing {

Roadmap MakeGridRoadmap(const World& world, const DistanceField& field, double spacing, double radius) {
  const bool space = world.dimension == 3;
  const int columns = static_cast<int>(world.bounds.size().x() / spacing) + 1;
  const int rows = static_cast<int>(world.bounds.size().y() / spacing) + 1;
  const int layers = space ? static_cast<int>(world.bounds.size().z() / spacing) + 1 : 1;
  const auto point = [&](const Eigen::Vector3i& cell) -> Vector3d {
    return world.bounds.min +
           Vector3d((cell.x() + 0.5) * spacing, (cell.y() + 0.5) * spacing, space ? (cell.z() + 0.5) * spacing : 0);
  };
  const auto index = [&](const Eigen::Vector3i& cell) {
    return static_cast<size_t>((cell.z() * rows + cell.y()) * columns + cell.x());
  };
  Roadmap roadmap;
  roadmap.dimension = world.dimension;
  std::vector<int> vertex(static_cast<size_t>(columns * rows * layers), -1);
  std::vector<Eigen::Vector3i> lattice;
  for (int i = 0; i < columns * rows * layers; ++i) {
    const Eigen::Vector3i cell(i % columns, i / columns % rows, i / (columns * rows));
    const Vector3d p = point(cell);
    if (field.Distance(p) < radius) continue;
    vertex[index(cell)] = static_cast<int>(lattice.size());
    lattice.push_back(cell);
    for (int k = 0; k < world.dimension; ++k) roadmap.positions.push_back(static_cast<float>(p[k]));
  }
  roadmap.offsets.push_back(0);
  for (const Eigen::Vector3i& cell : lattice) {
    for (int i = 0; i < 27; ++i) {
      const Eigen::Vector3i step(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      const Eigen::Vector3i next = cell + step;
      if (step.isZero() || (next.array() < 0).any() || next.x() >= columns || next.y() >= rows || next.z() >= layers) {
        continue;
      }
      const int neighbor = vertex[index(next)];
      if (neighbor < 0 || !field.SegmentClear(point(cell), point(next), radius)) continue;
      roadmap.neighbors.push_back(neighbor);
      roadmap.lengths.push_back(static_cast<float>(spacing * step.cast<double>().norm()));
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
  return std::make_shared<RoadmapLookup>(world.dimension, roadmap.positions, MakeCostTable(roadmap, world, world.goal),
                                         r_ball);
}

}  // namespace cairn::testing
