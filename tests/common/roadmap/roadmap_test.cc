#include "common/roadmap/roadmap.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/roadmap/roadmap_blob.h"

namespace cairn {
namespace {

Roadmap Square() {
  Roadmap roadmap;
  roadmap.positions = {0, 0, 1, 0, 1, 1, 0, 1};
  roadmap.offsets = {0, 1, 2, 2, 2};
  roadmap.neighbors = {1, 0};
  roadmap.lengths = {1, 1};
  return roadmap;
}

CostTable Table() {
  CostTable table;
  table.roadmap_hash = 5;
  table.goal = {Vector3d(0, 0, 0), Vector3d(0.1, 0.1, 0)};
  table.cost = {0, 1, 2, kUnreachable};
  table.next_vertex = {-1, 0, 1, -1};
  return table;
}

TEST(RoadmapTest, CountsFollowFromTheArrays) {
  const Roadmap roadmap = Square();
  EXPECT_EQ(roadmap.num_vertices(), 4);
  EXPECT_EQ(roadmap.num_edges(), 1);
  EXPECT_EQ(roadmap.num_places(), 4);
  EXPECT_EQ(roadmap.position(2), Vector3d(1, 1, 0));
}

TEST(RoadmapTest, HashDependsOnDimensionAndEveryPosition) {
  const Roadmap roadmap = Square();
  EXPECT_NE(roadmap.Hash(), 0u);
  EXPECT_EQ(roadmap.Hash(), Square().Hash());
  for (size_t i = 0; i < roadmap.positions.size(); ++i) {
    Roadmap other = roadmap;
    other.positions[i] += 1e-6f;
    EXPECT_NE(other.Hash(), roadmap.Hash());
  }
  Roadmap other = roadmap;
  other.dimension = 3;
  EXPECT_NE(other.Hash(), roadmap.Hash());
  other = roadmap;
  other.num_bends = 1;
  EXPECT_NE(other.Hash(), roadmap.Hash());
  other = roadmap;
  other.lengths[0] = 2;
  EXPECT_EQ(other.Hash(), roadmap.Hash());  // edges are not what actors receive
}

TEST(CostTableTest, HashDependsOnEveryField) {
  const CostTable table = Table();
  std::vector<CostTable> others(6, table);
  others[0].roadmap_hash = 6;
  others[1].goal.max.y() = 0.2;
  others[2].cost[1] = 1.5f;
  others[3].next_vertex[3] = 2;
  others[4].cost.pop_back();
  others[5].next_vertex.push_back(0);
  for (const CostTable& other : others) EXPECT_NE(other.Hash(), table.Hash());
  EXPECT_EQ(Table().Hash(), table.Hash());
  EXPECT_NE(CostTable{}.Hash(), 0u);
}

TEST(CostTableTest, LongestCostIgnoresUnreachableVertices) {
  EXPECT_EQ(Table().max_cost(), 2);
  EXPECT_EQ(CostTable{}.max_cost(), 0);
}

TEST(RoadmapBlobTest, RoundTripsAndRefusesDamage) {
  Roadmap roadmap;
  roadmap.positions = {0, 1, 2, 3};
  const auto positions = UnpackPositions(PackPositions(roadmap));
  ASSERT_TRUE(positions);
  EXPECT_EQ(positions->positions, roadmap.positions);
  EXPECT_EQ(positions->num_bends, 0);
  for (const int bends : {-1, 1, 2}) {  // of two vertices one at most
    roadmap.num_bends = bends;
    const auto bent = UnpackPositions(PackPositions(roadmap));
    ASSERT_EQ(bent.has_value(), bends == 1);
    if (bent) {
      EXPECT_EQ(bent->num_bends, 1);
    }
  }
  CostTable table;
  table.roadmap_hash = 5;
  table.goal.max = Vector3d(1, 2, 3);
  table.cost = {0, kUnreachable};
  table.next_vertex = {-1, -1};
  const Bytes blob = PackTable(table);
  const auto unpacked = UnpackTable(blob);
  ASSERT_TRUE(unpacked);
  EXPECT_EQ(unpacked->cost, table.cost);
  EXPECT_EQ(unpacked->goal.max, table.goal.max);
  for (size_t n = 0; n < blob.size(); ++n) EXPECT_FALSE(UnpackTable(ByteSpan(blob).first(n)));
  table.next_vertex = {2, -1};
  EXPECT_FALSE(UnpackTable(PackTable(table)));
  table.next_vertex = {-1, -1};
  table.cost[0] = -1;
  EXPECT_FALSE(UnpackTable(PackTable(table)));
}

}  // namespace
}  // namespace cairn
