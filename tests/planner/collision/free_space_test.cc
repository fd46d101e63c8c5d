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

// A closet of 0.5 m in a hall of 50 m: one draw from the bounds in ten thousand would lie in it.
TEST(FreeSpaceTest, AClosedPartIsDrawnFromItsSurroundings) {
  World world;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(50, 50, 0)};
  world.boxes = {{Vector3d(20, 20, 0), Vector3d(20.1, 20.7, 0)},
                 {Vector3d(20.6, 20, 0), Vector3d(20.7, 20.7, 0)},
                 {Vector3d(20, 20, 0), Vector3d(20.7, 20.1, 0)},
                 {Vector3d(20, 20.6, 0), Vector3d(20.7, 20.7, 0)}};
  world.start = world.goal = {Vector3d(20.2, 20.2, 0), Vector3d(20.3, 20.3, 0)};
  const DistanceField field(world, 0.05);
  const SweptSphereChecker checker(world, 0.05);
  const Reachability reachability(world, field, 0.05);
  const Box around = reachability.extent();
  EXPECT_LE((around.min - Vector3d(20.1, 20.1, 0)).norm(), 0.05);
  EXPECT_LE((around.max - Vector3d(20.6, 20.6, 0)).norm(), 0.05);
  const FreeSpace space(world, checker, reachability);
  RandomStream random(1, RandomPurpose::kTest), same(1, RandomPurpose::kTest);
  const auto p = space.Draw(random), from_part = space.Draw(around, same);
  ASSERT_TRUE(p.has_value());
  EXPECT_EQ(*p, *from_part);
}

TEST(FreeSpaceTest, OrdinaryWorldsAreDrawnFromTheirBounds) {
  const World world = TwoRooms(2);
  const DistanceField field(world, 0.01);
  const SweptSphereChecker checker(world, 0.05);
  const Reachability reachability(world, field, 0.05);
  const FreeSpace space(world, checker, reachability);
  RandomStream random(1, RandomPurpose::kTest), same(1, RandomPurpose::kTest);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(*space.Draw(random), *space.Draw(world.bounds, same));
}

}  // namespace
}  // namespace cairn::planner
