// Costs at default density against ways of any direction.
#include "tests/planner/cost_error.h"

#include <gtest/gtest.h>

namespace cairn::planner {
namespace {

constexpr double kTooLong = 0.004;  // by which the truths may be above the truth

TEST(CostErrorTest, CarMazeCostsAreNearTheShortestWays) {
  for (const int seed : {1, 2, 11}) {
    const CostWorld scene = RecipeWorld("car_maze.textproto", seed);
    const CostError error = MeasureCosts(scene, scene.Build().roadmap, 300);
    EXPECT_LE(error.mean, 0.02) << "world " << seed;
    EXPECT_GE(error.smallest, -kTooLong) << "world " << seed;
  }
}

TEST(CostErrorTest, FloorCostsAreNearTheShortestWays) {
  const CostWorld scene = RoomsFloor(3);
  const CostError error = MeasureCosts(scene, scene.Build().roadmap, 200);
  EXPECT_LE(error.mean, 0.02);
  EXPECT_GE(error.smallest, -kTooLong);
}

TEST(CostErrorTest, CubeCostsAreNearTheShortestWays) {
  const CostWorld scene = RecipeWorld("quadrotor_maze.textproto", 1);
  const CostError error = MeasureCosts(scene, scene.Build().roadmap, 60, 0.02);
  EXPECT_LE(error.mean, 0.04);
  EXPECT_GE(error.smallest, -2 * kTooLong);
}

TEST(CostErrorTest, NoCostIsReadThroughAWall) {
  for (const char* file : {"car_maze.textproto", "quadrotor_maze.textproto"}) {
    const CostWorld scene = RecipeWorld(file, 1);
    int finite = 0;
    EXPECT_EQ(CountReadThroughWalls(scene, scene.Build().roadmap, 10000, &finite), 0) << file;
    EXPECT_GT(finite, 8000) << file;
  }
}

// The counter counts: half an eta beyond what the planner accepts, costs are read through the maze's walls.
TEST(CostErrorTest, CostsReadThroughWallsAreCounted) {
  CostWorld scene = RecipeWorld("car_maze.textproto", 1);
  const Roadmap roadmap = scene.Build().roadmap;
  scene.config.eta *= 2.5;
  int finite = 0;
  EXPECT_GT(CountReadThroughWalls(scene, roadmap, 2000, &finite), 100);
}

}  // namespace
}  // namespace cairn::planner
