#include "common/world/cube_maze.h"

#include <gtest/gtest.h>

#include "common/core/check.h"
#include "common/world/distance_field.h"
#include "common/world/reachability.h"
#include "common/world/signed_distance.h"

namespace cairn {
namespace {

WorldConfig Config(uint64_t seed) {
  WorldConfig config;
  config.kind = WorldConfig::Kind::kCubeMaze;
  config.seed = seed;
  return config;
}

TEST(CubeMazeTest, IsThePapersCube) {
  const World world = MakeWorld(Config(1));
  EXPECT_EQ(world.dimension, 3);
  EXPECT_TRUE(world.bounds.min.isZero());
  EXPECT_TRUE(world.bounds.max.isApprox(Vector3d(1, 1, 1)));
  EXPECT_GT(world.goal.min.z(), 0.75);
  EXPECT_DOUBLE_EQ(world.start_space.max.z(), 0.75);
  EXPECT_EQ(world.start.max.z(), world.start_space.max.z());
}

// Middle of the tile's plane free: a hole of the stated size; else the whole tile is wall.
TEST(CubeMazeTest, EveryFloorIsConnectedByDoorsAndHasOneShaft) {
  for (const uint64_t seed : {1, 21, 22, 23}) {
    const World world = MakeWorld(Config(seed));
    for (int floor = 0; floor < 4; ++floor) {
      int doors = 0, shafts = 0;
      for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) {
          const double u = 0.25 * (a + 0.5), v = 0.25 * (b + 0.5), z = 0.25 * (floor + 0.5);
          if (a < 3) doors += SignedDistance(world, Vector3d(0.25 * (a + 1), v, z)) > 0;
          if (a < 3) doors += SignedDistance(world, Vector3d(v, 0.25 * (a + 1), z)) > 0;
          if (floor < 3) shafts += SignedDistance(world, Vector3d(u, v, 0.25 * (floor + 1))) > 0;
        }
      }
      EXPECT_GE(doors, 15 + 1) << "a spanning tree of 16 rooms and loops";
      EXPECT_EQ(shafts, floor < 3 ? 1 : 0);
    }
  }
}

TEST(CubeMazeTest, HolesHaveTheirSize) {
  const World world = MakeWorld(Config(3));
  ASSERT_FALSE(world.doors.empty());
  for (const Box& door : world.doors) {
    const Vector3d center = door.center();
    EXPECT_NEAR(SignedDistance(world, center), 0.08, 1e-9) << "half a door to its frame";
    int axis;
    door.size().minCoeff(&axis);
    for (int k = 0; k < 3; ++k) {
      if (k == axis) continue;
      Vector3d inside = center, outside = center;
      inside[k] += 0.0799;
      outside[k] += 0.0801;
      EXPECT_GT(SignedDistance(world, inside), 0);
      EXPECT_LT(SignedDistance(world, outside), 0);
    }
  }
}

// The goal can be reached by a sphere of 45 mm from every room below: flood fill from the goal reaches their middles.
TEST(CubeMazeTest, EveryRoomLeadsToTheGoal) {
  for (uint64_t seed = 21; seed <= 28; ++seed) {
    const World world = MakeWorld(Config(seed));
    const DistanceField field(world, 0.01);
    const Reachability reachability(world, field, 0.05);
    for (int room = 0; room < 64; ++room) {
      const Vector3d middle = 0.25 * Vector3d(room % 4 + 0.5, room / 4 % 4 + 0.5, room / 16 + 0.5);
      EXPECT_TRUE(reachability.Reaches(middle)) << "seed " << seed << " room " << room;
    }
  }
}

TEST(CubeMazeTest, DependsOnTheSeedAlone) {
  const World a = MakeWorld(Config(5)), b = MakeWorld(Config(5)), c = MakeWorld(Config(6));
  ASSERT_EQ(a.boxes.size(), b.boxes.size());
  for (size_t i = 0; i < a.boxes.size(); ++i) {
    EXPECT_EQ(a.boxes[i].min, b.boxes[i].min);
    EXPECT_EQ(a.boxes[i].max, b.boxes[i].max);
  }
  bool same = a.boxes.size() == c.boxes.size();
  for (size_t i = 0; same && i < a.boxes.size(); ++i) same = a.boxes[i].min == c.boxes[i].min;
  EXPECT_FALSE(same);
}

TEST(CubeMazeTest, RefusesHolesThatDoNotFit) {
  WorldConfig config = Config(1);
  config.door_size = 0.24;
  try {
    MakeWorld(config);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("world.door_size = 0.24"), std::string::npos) << error.what();
  }
  config.door_size = 0.16;
  config.wall_thickness = 0.3;
  EXPECT_THROW(MakeWorld(config), UsageError);
}

}  // namespace
}  // namespace cairn
