#include "planner/repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/planner.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

constexpr double kRadius = 0.04;

BuiltRoadmap Build(const World& world) {
  PlannerConfig config;
  config.eta = 0.18;
  config.radius = kRadius;
  config.min_spacing = 0.06;
  config.coverage = 0.99;
  return BuildRoadmap(world, DistanceField(world, 0.01), config, kRadius);
}

// Distance from the segment to the box, by looking at many points: at most `step` / 2 too large.
double SampledDistance(const Box& box, const Vector3d& a, const Vector3d& b, double* step) {
  constexpr int kSteps = 400;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    const Vector3d p = a + (b - a) * (1.0 * i / kSteps);
    least = std::min(least, (p - p.cwiseMax(box.min).cwiseMin(box.max)).norm());
  }
  *step = (b - a).norm() / kSteps;
  return least;
}

class BlockEdgesTest : public testing::TestWithParam<int> {
 protected:
  const World world_ = TwoRooms(GetParam());
  const Roadmap roadmap_ = Build(world_).roadmap;
};

TEST_P(BlockEdgesTest, CutsExactlyTheEdgesThatComeTooNear) {
  RandomStream random(3, RandomPurpose::kTest);
  for (const Vector3d& size : {Vector3d(0, 0, 0), Vector3d(0.05, 0.2, 0.1), Vector3d(0, 0.3, 0)}) {
    const Vector3d corner = DrawIn(world_, random);
    const Box mark{corner, corner + size};
    Roadmap blocked = roadmap_;
    int entries = 0;
    const int cut = BlockEdges({mark}, 0.5 * kRadius, &blocked);
    for (int v = 0; v < roadmap_.num_vertices(); ++v) {
      for (int e = roadmap_.offsets[v]; e < roadmap_.offsets[v + 1]; ++e) {
        Box flat = mark;
        if (world_.dimension == 2) flat.min.z() = flat.max.z() = 0;
        double step = 0;
        const Vector3d a = roadmap_.position(v), b = roadmap_.position(roadmap_.neighbors[e]);
        const double least = SampledDistance(flat, a, b, &step);
        const bool is_cut = std::isinf(blocked.lengths[e]);
        entries += is_cut;
        ASSERT_TRUE(is_cut || blocked.lengths[e] == roadmap_.lengths[e]);
        ASSERT_FALSE(is_cut && least > 0.5 * kRadius + step) << a.transpose() << " to " << b.transpose();
        ASSERT_FALSE(!is_cut && least <= 0.5 * kRadius) << a.transpose() << " to " << b.transpose();
      }
    }
    EXPECT_EQ(entries, 2 * cut) << "an edge is cut in both directions";
    EXPECT_EQ(BlockEdges({mark}, 0.5 * kRadius, &blocked), 0) << "cut already";
  }
}

TEST_P(BlockEdgesTest, AShutDoorLeavesTheOtherRoomWithoutACost) {
  Roadmap blocked = roadmap_;
  const Box door{Vector3d(1, 0.4, 0), Vector3d(1.05, 0.6, world_.bounds.max.z())};
  EXPECT_GT(BlockEdges({door}, kRadius, &blocked), 0);
  const CostTable before = ComputeCostTable(roadmap_, world_, world_.goal);
  const CostTable after = ComputeCostTable(blocked, world_, world_.goal);
  EXPECT_EQ(after.roadmap_hash, before.roadmap_hash) << "whoever has the positions keeps them";
  EXPECT_NE(after.Hash(), before.Hash());
  for (int v = 0; v < roadmap_.num_vertices(); ++v) {
    const bool same_room = roadmap_.position(v).x() > 1.05 + kRadius;
    EXPECT_TRUE(std::isfinite(before.cost[v]));
    EXPECT_EQ(std::isfinite(after.cost[v]), same_room) << roadmap_.position(v).transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(PlaneAndSpace, BlockEdgesTest, testing::Values(2, 3));

}  // namespace
}  // namespace cairn::planner
