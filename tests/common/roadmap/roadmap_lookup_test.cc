#include "common/roadmap/roadmap_lookup.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/check.h"
#include "common/core/random.h"

namespace cairn {
namespace {

struct Cloud {
  std::vector<float> positions;
  CostTable table;
};

// Vertices scattered over [2, 4] × [−1, 1] (× [5, 6]); every tenth is unreachable; next: a cheaper vertex or −1.
Cloud Scatter(int dimension, int vertices, uint64_t seed) {
  RandomStream random(seed, RandomPurpose::kTest);
  Cloud cloud;
  for (int v = 0; v < vertices; ++v) {
    for (const double low : {2.0, -1.0}) cloud.positions.push_back(static_cast<float>(random.Uniform(low, low + 2)));
    if (dimension == 3) cloud.positions.push_back(static_cast<float>(random.Uniform(5, 6)));
    cloud.table.cost.push_back(v % 10 == 9 ? kUnreachable : static_cast<float>(random.Uniform(0, 9)));
    cloud.table.next_vertex.push_back(-1);
  }
  return cloud;
}

Vector3d Draw(RandomStream& random) {
  return Vector3d(random.Uniform(1.8, 4.2), random.Uniform(-1.2, 1.2), random.Uniform(4.9, 6.1));
}

class RoadmapLookupTest : public testing::TestWithParam<int> {};

TEST_P(RoadmapLookupTest, CostToGoIsTheCheapestVertexInTheBall) {
  const int dimension = GetParam();
  for (const double r_ball : {0.02, 0.1, 0.7}) {
    const Cloud cloud = Scatter(dimension, 1000, 1);
    const RoadmapLookup lookup(dimension, cloud.positions, cloud.table, r_ball);
    RandomStream random(2, RandomPurpose::kTest);
    int finite = 0;
    for (int i = 0; i < 500; ++i) {
      const Vector3d p = Draw(random);
      float expected = kUnreachable;
      for (int v = 0; v < lookup.num_vertices(); ++v) {
        const Vector3d d = lookup.position(v) - p;
        const double squared = dimension == 3 ? d.squaredNorm() : d.head<2>().squaredNorm();
        if (squared <= r_ball * r_ball) expected = std::min(expected, cloud.table.cost[v]);
      }
      ASSERT_EQ(lookup.CostToGo(p), expected) << p.transpose() << " r_ball " << r_ball;
      finite += std::isfinite(expected);
    }
    EXPECT_GT(finite, 0);
  }
}

TEST_P(RoadmapLookupTest, CostToGoIsInfiniteFarAwayAndForNan) {
  const Cloud cloud = Scatter(GetParam(), 100, 1);
  const RoadmapLookup lookup(GetParam(), cloud.positions, cloud.table, 0.1);
  EXPECT_EQ(lookup.CostToGo(Vector3d(100, 100, 100)), kUnreachable);
  EXPECT_EQ(lookup.CostToGo(Vector3d(-1e300, 0, 5.5)), kUnreachable);
  EXPECT_EQ(lookup.CostToGo(Vector3d(std::nan(""), 0, 5.5)), kUnreachable);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, RoadmapLookupTest, testing::Values(2, 3));

// A wall between the query point and the cheap vertex:   0 (cost 1) | wall | p . 1 (cost 3) . 2 (cost 2.9, skirting)
struct Walled {
  World world;
  Cloud cloud;

  Walled() {
    world.bounds = {Vector3d(0, 0, 0), Vector3d(2, 1, 0)};
    world.boxes = {{Vector3d(0.98, 0, 0), Vector3d(1, 0.6, 0)}};
    cloud.positions = {0.9f, 0.5f, 1.2f, 0.5f, 1.05f, 0.62f};
    cloud.table.cost = {1, 3, 2.9f};
    cloud.table.next_vertex = {-1, 2, 0};
  }
  RoadmapLookup Lookup(double r_ball) const { return RoadmapLookup(2, cloud.positions, cloud.table, r_ball); }
};

TEST(RoadmapEntryTest, PrefersTheShortestPathInSight) {
  const Walled w;
  const DistanceField field(w.world, 0.005);
  const RoadmapLookup lookup = w.Lookup(0.15);
  const Vector3d p(1.1, 0.5, 0);
  EXPECT_EQ(lookup.EntryVertex(p, field, 0.01), 2);   // 0.13 + 2.9 beats 0.1 + 3; vertex 0 hides behind the wall
  EXPECT_EQ(lookup.EntryVertex(p, field, 0.055), 1);  // vertex 2 lies 0.054 m from the wall's end
}

TEST(RoadmapEntryTest, WaysBeginAtBendsButCostsAreNotReadThere) {
  const Walled w;
  const DistanceField field(w.world, 0.005);
  const RoadmapLookup lookup(2, w.cloud.positions, w.cloud.table, 0.15, 1);  // vertex 2 is a bend
  const Vector3d p(1.1, 0.5, 0);
  EXPECT_EQ(w.Lookup(0.15).CostToGo(p), 2.9f);
  EXPECT_EQ(lookup.CostToGo(p), 3);
  EXPECT_EQ(lookup.EntryVertex(p, field, 0.01), 2);
  EXPECT_THROW(RoadmapLookup(2, w.cloud.positions, w.cloud.table, 0.15, 4), Error);
  EXPECT_THROW(RoadmapLookup(2, w.cloud.positions, w.cloud.table, 0.15, -1), Error);
}

TEST(RoadmapEntryTest, FallsBackToNoClearanceAndThenToTheNearest) {
  const Walled w;
  const DistanceField field(w.world, 0.005);
  const RoadmapLookup lookup = w.Lookup(0.15);
  EXPECT_EQ(lookup.EntryVertex(Vector3d(1.1, 0.5, 0), field, 0.9), 2);     // none keeps 0.9 m, so 0 m
  EXPECT_EQ(lookup.EntryVertex(Vector3d(0.985, 0.2, 0), field, 0.01), 0);  // inside the wall: nearest
  EXPECT_EQ(lookup.EntryVertex(Vector3d(1.9, 0.1, 0), field, 0.01), 1);    // out of range of all: nearest
}

TEST(RoadmapEntryTest, IsMinusOneWithoutAReachableVertex) {
  Walled w;
  w.cloud.table.cost.assign(3, kUnreachable);
  const DistanceField field(w.world, 0.005);
  EXPECT_EQ(w.Lookup(0.15).EntryVertex(Vector3d(1.1, 0.5, 0), field, 0.01), -1);
}

TEST(RoadmapPathTest, PointAlongFollowsTheTableAndStopsInTheMiddleOfTheGoal) {
  Cloud cloud;
  cloud.table.goal = {{-0.2, -0.4, 0}, {0.2, 0, 1}};
  cloud.positions = {0, 0, 1, 0, 1, 2};  // an L: 2 → 1 → 0, which is at the goal's edge
  cloud.table.cost = {0, 1, 3};
  cloud.table.next_vertex = {-1, 0, 1};
  const RoadmapLookup lookup(2, cloud.positions, cloud.table, 0.1);
  const Vector3d p(1, 2.5, 0);
  const auto at = [&](double s) { return lookup.PointAlong(p, 2, s); };
  EXPECT_TRUE(at(0).isApprox(p));
  EXPECT_TRUE(at(0.25).isApprox(Vector3d(1, 2.25, 0)));
  EXPECT_TRUE(at(0.5).isApprox(Vector3d(1, 2, 0)));
  EXPECT_TRUE(at(2).isApprox(Vector3d(1, 0.5, 0)));
  EXPECT_TRUE(at(3).isApprox(Vector3d(0.5, 0, 0)));
  EXPECT_TRUE(at(3.6).isApprox(Vector3d(0, -0.1, 0)));
  EXPECT_TRUE(at(99).isApprox(Vector3d(0, -0.2, 0)));
  EXPECT_TRUE(lookup.PointAlong(Vector3d(0, 0, 0), 0, 0.1).isApprox(Vector3d(0, -0.1, 0)));
  EXPECT_TRUE(lookup.PointAlong(lookup.position(2), 2, 0.5).isApprox(Vector3d(1, 1.5, 0)));
}

TEST(RoadmapPathTest, ACycleInAForeignTableDoesNotHang) {
  Cloud cloud;
  cloud.positions = {0, 0, 1, 0};
  cloud.table.cost = {1, 1};
  cloud.table.next_vertex = {1, 0};
  const RoadmapLookup lookup(2, cloud.positions, cloud.table, 0.1);
  EXPECT_TRUE(lookup.PointAlong(Vector3d(0, 0, 0), 0, 1e9).allFinite());
}

TEST(RoadmapLookupCheckTest, RejectsTablesThatDoNotFit) {
  const Cloud cloud = Scatter(2, 10, 1);
  EXPECT_THROW(RoadmapLookup(3, cloud.positions, cloud.table, 0.1), Error);
  EXPECT_THROW(RoadmapLookup(4, cloud.positions, cloud.table, 0.1), Error);
  EXPECT_THROW(RoadmapLookup(2, cloud.positions, cloud.table, 0), Error);
  CostTable table = cloud.table;
  table.next_vertex[3] = 10;
  EXPECT_THROW(RoadmapLookup(2, cloud.positions, table, 0.1), Error);
  std::vector<float> positions = cloud.positions;
  positions[4] = std::nanf("");
  EXPECT_THROW(RoadmapLookup(2, positions, cloud.table, 0.1), Error);
  EXPECT_EQ(RoadmapLookup(2, {}, CostTable{}, 0.1).CostToGo(Vector3d::Zero()), kUnreachable);
}

// Two vertices, the goal's at (0.3, 0), and a mark between p and it.
TEST(RoadmapLookupTest, NoLineLeadsNearerToAMark) {
  CostTable table{1, Box{}, {0.2f, 0}, {1, -1}};
  table.marks = {0.24f, 0.01f, 0};
  table.mark_reach = 0.03f;
  World world;
  world.bounds = {Vector3d(-1, -1, 0), Vector3d(1, 1, 0)};
  const DistanceField field(world, 0.01);
  const std::vector<float> positions{0.1f, 0, 0.3f, 0};
  const RoadmapLookup marked(2, positions, table, 0.12);
  const Vector3d p(0.19, 0, 0);
  EXPECT_EQ(marked.CostToGo(p), 0.2f);
  EXPECT_EQ(marked.EntryVertex(p, field, 0), 0);
  EXPECT_EQ(marked.CostToGo(Vector3d(0.25, 0, 0)), 0) << "within the mark's reach, a way out is open";
  table.marks.clear();
  const RoadmapLookup unmarked(2, positions, table, 0.12);
  EXPECT_EQ(unmarked.CostToGo(p), 0);
  EXPECT_EQ(unmarked.EntryVertex(p, field, 0), 1);
}

}  // namespace
}  // namespace cairn
