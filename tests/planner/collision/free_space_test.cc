#include "planner/collision/free_space.h"

#include <gtest/gtest.h>

#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

TEST(FreeSpaceTest, PointsAreRoundedAsARoadmapStoresThem) {
  const Vector3d p = RoundToFloat(Vector3d(0.1, 1.2, 0.3), 3);
  EXPECT_EQ(p, Vector3d(0.1f, 1.2f, 0.3f));
  EXPECT_EQ(RoundToFloat(Vector3d(0.1, 1.2, 0.3), 2), Vector3d(0.1f, 1.2f, 0));
}

TEST(FreeSpaceTest, DrawsAreRounded) {
  const World world = TwoRooms(2);
  const DistanceField field(world, 0.01);
  const SweptSphereChecker checker(world, 0.05);
  const Reachability reachability(world, field, 0.05);
  const FreeSpace space(world, checker, reachability);
  RandomStream random(1, RandomPurpose::kTest);
  for (int i = 0; i < 100; ++i) {
    const auto p = space.Draw(world.bounds, random);
    ASSERT_TRUE(p.has_value());
    for (int k = 0; k < 2; ++k) EXPECT_EQ(static_cast<float>((*p)[k]) - (*p)[k], 0);
  }
}

}  // namespace
}  // namespace cairn::planner
