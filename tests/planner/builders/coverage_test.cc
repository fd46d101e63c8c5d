#include "planner/builders/coverage.h"

#include <gtest/gtest.h>

#include "common/world/reachability.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

TEST(CoverageTest, IsTheShareOfFreeSpaceNearAVertex) {
  World world;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(1.1, 1.1, 0)};
  world.start = world.goal = {Vector3d(0.4, 0.4, 0), Vector3d(0.6, 0.6, 0)};
  const DistanceField field(world, 0.01);
  const SweptSphereChecker checker(world, 0.05);  // free: the middle 1 m × 1 m
  const Reachability reachability(world, field, 0.05);
  const FreeSpace space(world, checker, reachability);
  Coverage coverage(space, 0.2, 20000, 1);
  EXPECT_EQ(coverage.share(), 0);
  coverage.AddVertex(Vector3d(0.55, 0.55, 0));
  EXPECT_NEAR(coverage.share(), 0.12566, 0.008);  // π 0.2²; three standard deviations are 0.007
  coverage.AddVertex(Vector3d(0.55, 0.55, 0));
  EXPECT_NEAR(coverage.share(), 0.12566, 0.008);  // counted once
  coverage.AddVertex(Vector3d(0.05, 0.05, 0));
  EXPECT_NEAR(coverage.share(), 1.25 * 0.12566, 0.01);
}

TEST(CoverageTest, CountsOnlyWhatReachesTheGoal) {
  World world = TwoRooms(2);
  world.boxes = {{Vector3d(1, 0, 0), Vector3d(1.05, 1, 0)}};  // no door
  const DistanceField field(world, 0.01);
  const SweptSphereChecker checker(world, 0.05);
  const Reachability reachability(world, field, 0.05);
  const FreeSpace space(world, checker, reachability);
  RandomStream random(1, RandomPurpose::kTest);
  for (int i = 0; i < 2000; ++i) {
    const auto p = space.Draw(world.bounds, random);
    ASSERT_TRUE(p.has_value());
    EXPECT_GE(p->x(), 1.1);
    EXPECT_GE(SignedDistance(world, *p), 0.05);
  }
}

}  // namespace
}  // namespace cairn::planner
