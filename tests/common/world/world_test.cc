#include "common/world/world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "common/core/check.h"

namespace cairn {
namespace {

WorldConfig Boxes() {
  WorldConfig config;
  config.kind = WorldConfig::Kind::kBoxes;
  config.bounds = {{0, 0, 0}, {4, 2, 0}};
  config.obstacles = {{{1, 0, 0}, {1.1, 1, 0}}, {{2, 1, 5}, {2.1, 3, 6}}};
  config.start = {{0.1, 0.1, 0}, {0.5, 0.5, 0}};
  config.goal = {{3, 1, 0}, {4, 2, 0}};
  return config;
}

std::string Message(const WorldConfig& config) {
  try {
    MakeWorld(config);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(WorldTest, BoxesAreTakenAsListedAndZIsIgnored) {
  const World world = MakeWorld(Boxes());
  ASSERT_EQ(world.dimension, 2);
  ASSERT_EQ(world.boxes.size(), 2u);
  EXPECT_EQ(world.boxes[1].min, Vector3d(2, 1, 0));
  EXPECT_EQ(world.boxes[1].max, Vector3d(2.1, 3, 0));
}

TEST(WorldTest, RegionsContainTheirEdges) {
  const World world = MakeWorld(Boxes());
  EXPECT_TRUE(world.Contains(world.goal, Vector3d(3, 1, 77)));
  EXPECT_TRUE(world.Contains(world.goal, Vector3d(4, 2, 0)));
  EXPECT_FALSE(world.Contains(world.goal, Vector3d(2.999, 1.5, 0)));
  EXPECT_FALSE(world.Contains(world.goal, Vector3d(3.5, std::numeric_limits<double>::quiet_NaN(), 0)));
}

TEST(WorldTest, RejectsEmptyRegionsByName) {
  WorldConfig config = Boxes();
  config.goal.max[0] = 3;
  EXPECT_THAT(Message(config), testing::HasSubstr("world.goal: x from 3 to 3 m"));
  config = Boxes();
  config.start = {};
  EXPECT_THAT(Message(config), testing::HasSubstr("world.start: x"));
  config = Boxes();
  config.obstacles[1].max[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Message(config), testing::HasSubstr("world.obstacles[1]: y from 1 to nan m"));
  config = Boxes();
  config.bounds.max[1] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(Message(config), testing::HasSubstr("world.bounds: y"));
}

TEST(WorldTest, RejectsWhatLiesOutsideTheBounds) {
  WorldConfig config = Boxes();
  config.goal.max[0] = 4.5;
  EXPECT_THAT(Message(config), testing::HasSubstr("world.goal: x from 3 to 4.5 m must lie within world.bounds"));
  config = Boxes();
  config.obstacles[0] = {{5, 0, 0}, {6, 1, 0}};
  EXPECT_THAT(Message(config), testing::HasSubstr("world.obstacles[0]: x from 5 to 6 m lies outside world.bounds"));
}

}  // namespace
}  // namespace cairn
