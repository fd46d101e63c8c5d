#include "planner/cost_to_go.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/check.h"
#include "common/core/random.h"
#include "planner/planner.h"

namespace cairn::planner {
namespace {

// A random graph over the unit square with several components.
Roadmap RandomGraph(uint64_t seed, int vertices, int edges) {
  RandomStream random(seed, RandomPurpose::kTest);
  Roadmap roadmap;
  for (int i = 0; i < 2 * vertices; ++i) roadmap.positions.push_back(static_cast<float>(random.Uniform()));
  std::vector<std::vector<int32_t>> neighbors(vertices);
  for (int i = 0; i < edges; ++i) {
    const auto u = static_cast<int32_t>(random.Below(vertices)), v = static_cast<int32_t>(random.Below(vertices));
    if (u == v) continue;
    neighbors[u].push_back(v);
    neighbors[v].push_back(u);
  }
  roadmap.offsets.push_back(0);
  for (int32_t u = 0; u < vertices; ++u) {
    for (const int32_t v : neighbors[u]) {
      roadmap.neighbors.push_back(v);
      roadmap.lengths.push_back(static_cast<float>((roadmap.position(u) - roadmap.position(v)).norm()));
    }
    roadmap.offsets.push_back(static_cast<int32_t>(roadmap.neighbors.size()));
  }
  return roadmap;
}

// Relaxes all edges until nothing changes.
std::vector<float> BellmanFord(const Roadmap& roadmap, const std::vector<int32_t>& sources) {
  std::vector<float> cost(roadmap.num_vertices(), kUnreachable);
  for (const int32_t s : sources) cost[s] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (int v = 0; v < roadmap.num_vertices(); ++v) {
      for (int e = roadmap.offsets[v]; e < roadmap.offsets[v + 1]; ++e) {
        const float through = cost[roadmap.neighbors[e]] + roadmap.lengths[e];
        if (through < cost[v]) {
          cost[v] = through;
          changed = true;
        }
      }
    }
  }
  return cost;
}

TEST(CostToGoTest, AgreesWithBellmanFord) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const Roadmap roadmap = RandomGraph(seed, 300, 330);
    const std::vector<int32_t> sources{3, 50, 3, 299};
    const ShortestPaths paths = ComputeShortestPaths(roadmap, sources);
    EXPECT_EQ(paths.cost, BellmanFord(roadmap, sources));
    EXPECT_TRUE(std::isinf(*std::max_element(paths.cost.begin(), paths.cost.end()))) << "the test wants islands";
  }
}

TEST(CostToGoTest, NextVerticesLeadAlongEdgesToASourceAtTheStatedCost) {
  const Roadmap roadmap = RandomGraph(4, 300, 500);
  const ShortestPaths paths = ComputeShortestPaths(roadmap, {7, 8});
  for (int v = 0; v < roadmap.num_vertices(); ++v) {
    const int next = paths.next_vertex[v];
    if (next < 0) {
      EXPECT_TRUE(v == 7 || v == 8 || std::isinf(paths.cost[v]));
      continue;
    }
    bool edge = false;
    for (int e = roadmap.offsets[v]; e < roadmap.offsets[v + 1]; ++e) {
      edge |= roadmap.neighbors[e] == next && paths.cost[next] + roadmap.lengths[e] == paths.cost[v];
    }
    EXPECT_TRUE(edge) << v;
  }
}

TEST(CostTableTest, SourcesAreTheVerticesInTheGoalRegion) {
  const Roadmap roadmap = RandomGraph(5, 200, 400);
  World world;
  world.goal = {Vector3d(0.8, 0.8, 0), Vector3d(1, 1, 0)};
  const CostTable table = ComputeCostTable(roadmap, world, world.goal);
  EXPECT_EQ(table.roadmap_hash, roadmap.Hash());
  for (int v = 0; v < roadmap.num_vertices(); ++v) {
    EXPECT_EQ(table.cost[v] == 0, world.Contains(world.goal, roadmap.position(v))) << v;
  }
}

TEST(CostTableTest, RefusesAGoalWithoutVertices) {
  const Roadmap roadmap = RandomGraph(5, 200, 400);
  World world;
  const Box goal = {Vector3d(2, 2, 0), Vector3d(3, 3, 0)};
  EXPECT_THROW(ComputeCostTable(roadmap, world, goal), UsageError);
}

}  // namespace
}  // namespace cairn::planner
