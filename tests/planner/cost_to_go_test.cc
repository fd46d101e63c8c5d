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

// 0 —— 1 —— 2 along x = 0, 1, 2, and 3 at (1, 1) with edges to 0 and 2; the goal is x ≥ 1.75.
Roadmap Ladder() {
  Roadmap roadmap;
  roadmap.positions = {0, 0, 1, 0, 2, 0, 1, 1};
  roadmap.offsets = {0, 2, 4, 6, 8};
  roadmap.neighbors = {1, 3, 0, 2, 1, 3, 0, 2};
  const auto diagonal = static_cast<float>(std::sqrt(2.0));
  roadmap.lengths = {1, diagonal, 1, 1, 1, diagonal, diagonal, diagonal};
  return roadmap;
}

TEST(CostTableTest, WaysOfATautRoadmapEndAtTheGoalsBorder) {
  Roadmap roadmap = Ladder();
  World world;
  const Box goal{Vector3d(1.75, -1, 0), Vector3d(3, 1, 0)};
  EXPECT_EQ(ComputeCostTable(roadmap, world, goal).cost, (std::vector<float>{2, 1, 0, roadmap.lengths[1]}));
  roadmap.taut = true;
  const CostTable table = ComputeCostTable(roadmap, world, goal);
  EXPECT_EQ(table.next_vertex, (std::vector<int32_t>{1, 2, -1, 2}));
  EXPECT_FLOAT_EQ(table.cost[0], 1.75f);
  EXPECT_FLOAT_EQ(table.cost[1], 0.75f);
  EXPECT_EQ(table.cost[2], 0);
  EXPECT_FLOAT_EQ(table.cost[3], 0.75f * roadmap.lengths[1]);
}

TEST(ShareOutsideTest, IsWhereTheSegmentEntersTheBox) {
  const Box box{Vector3d(1, 1, 1), Vector3d(2, 2, 2)};
  const Vector3d inside(1.5, 1.5, 1.5);
  EXPECT_EQ(ShareOutside(box, 3, Vector3d(1.2, 1.9, 1), inside), 0);
  EXPECT_DOUBLE_EQ(ShareOutside(box, 3, Vector3d(0.5, 1.5, 1.5), inside), 0.5);
  EXPECT_DOUBLE_EQ(ShareOutside(box, 3, Vector3d(0.5, 1.5, 3.5), inside), 0.75);
  EXPECT_DOUBLE_EQ(ShareOutside(box, 2, Vector3d(0.5, 1.5, 3.5), inside), 0.5);
}

TEST(CostTableTest, RefusesAGoalWithoutVertices) {
  const Roadmap roadmap = RandomGraph(5, 200, 400);
  World world;
  const Box goal = {Vector3d(2, 2, 0), Vector3d(3, 3, 0)};
  EXPECT_THROW(ComputeCostTable(roadmap, world, goal), UsageError);
}

}  // namespace
}  // namespace cairn::planner
