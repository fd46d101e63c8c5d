#include "common/world/reachability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/core/check.h"
#include "common/core/random.h"

namespace cairn {
namespace {

// Two rooms, 1 m × 1 m each, joined by a door of 0.1 m in the wall x = 1 … 1.05.
World TwoRooms(double door) {
  World world;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(2, 1, 0)};
  world.boxes = {{Vector3d(1, 0, 0), Vector3d(1.05, 0.5 - door / 2, 0)},
                 {Vector3d(1, 0.5 + door / 2, 0), Vector3d(1.05, 1, 0)}};
  world.start = {Vector3d(0, 0, 0), Vector3d(0.2, 0.2, 0)};
  world.goal = {Vector3d(1.7, 0.7, 0), Vector3d(1.9, 0.9, 0)};
  return world;
}

std::string Message(const World& world, double radius) {
  const DistanceField field(world, 0.01);
  try {
    Reachability(world, field, radius).CheckStart();
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(ReachabilityTest, ADoorWiderThanTheRobotLetsItThrough) { EXPECT_EQ(Message(TwoRooms(0.1), 0.04), ""); }

TEST(ReachabilityTest, ADoorNarrowerThanTheRobotDoesNot) {
  EXPECT_THAT(Message(TwoRooms(0.1), 0.06),
              testing::AllOf(testing::HasSubstr("world.goal"), testing::HasSubstr("world.start"),
                             testing::HasSubstr("radius of 0.06 m")));
  const World world = TwoRooms(0.1);
  const DistanceField field(world, 0.01);
  const Reachability reachability(world, field, 0.06);
  EXPECT_TRUE(reachability.Reaches(Vector3d(1.3, 0.2, 0)));
  EXPECT_FALSE(reachability.Reaches(Vector3d(0.5, 0.5, 0)));
  EXPECT_FALSE(reachability.Reaches(Vector3d(2.5, 0.5, 0)));
}

TEST(ReachabilityTest, AGoalInsideAWallIsNamed) {
  World world = TwoRooms(0.1);
  world.goal = {Vector3d(1.01, 0.1, 0), Vector3d(1.03, 0.2, 0)};
  EXPECT_THAT(Message(world, 0.033),
              testing::AllOf(testing::HasSubstr("world.goal [1.01, 1.03] × [0.1, 0.2] m: no point of it is free"),
                             testing::HasSubstr("the nearest point that is: 0.96,0.15")));
}

// 0.06 from the walls leave 0.88 of the rooms' height, 0.88 of one's width and 0.83 of the other's, and a little at the
// door.
TEST(ReachabilityTest, SharesOfFreeSpaceAreCountedInNodes) {
  const World world = TwoRooms(0.1);
  const DistanceField field(world, 0.01);
  EXPECT_NEAR(Reachability(world, field, 0.06).share(), 84.0 / (84 + 89), 1e-3);
  EXPECT_EQ(Reachability(world, field, 0.04).share(), 1);
}

TEST(ReachabilityTest, AStartInsideAWallIsNamed) {
  World world = TwoRooms(0.1);
  world.start = {Vector3d(1.01, 0.1, 0), Vector3d(1.04, 0.2, 0)};
  EXPECT_THAT(Message(world, 0.03),
              testing::HasSubstr("world.start [1.01, 1.04] × [0.1, 0.2] m: no point of it is free"));
}

TEST(ReachabilityTest, AGoalSmallerThanAGridCellCounts) {
  World world = TwoRooms(0.1);
  world.goal = {Vector3d(1.7021, 0.7021, 0), Vector3d(1.7022, 0.7022, 0)};
  EXPECT_EQ(Message(world, 0.04), "");
}

TEST(ReachabilityTest, GoalPointIsTheRoomiestOfTheRegion) {
  const World world = TwoRooms(0.1);
  const DistanceField field(world, 0.01);
  const Reachability reachability(world, field, 0.04);
  EXPECT_TRUE(world.Contains(world.goal, reachability.goal_point()));
  RandomStream random(1, RandomPurpose::kTest);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d p(random.Uniform(1.7, 1.9), random.Uniform(0.7, 0.9), 0);
    EXPECT_LE(field.Distance(p), field.Distance(reachability.goal_point()) + 0.015);
  }
}

TEST(ReachabilityTest, EveryPaperMazeCanBeSolved) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    WorldConfig config;
    config.seed = seed;
    const World world = MakeWorld(config);
    const DistanceField field(world, config.field_resolution);
    EXPECT_NO_THROW(Reachability(world, field, 0.03).CheckStart());
  }
}

TEST(ReachabilityTest, WorksInSpace) {
  World world;
  world.dimension = 3;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(1, 1, 1)};
  world.boxes = {{Vector3d(0, 0, 0.5), Vector3d(0.8, 1, 0.52)}};  // a ceiling that leaves a gap of 0.2 m
  world.start = {Vector3d(0, 0, 0), Vector3d(0.3, 0.3, 0.3)};
  world.goal = {Vector3d(0, 0, 0.7), Vector3d(0.3, 0.3, 1)};
  EXPECT_EQ(Message(world, 0.09), "");
  EXPECT_THAT(Message(world, 0.11), testing::HasSubstr("cannot be reached"));
}

}  // namespace
}  // namespace cairn
