#include "planner/planner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/core/check.h"
#include "common/roadmap/roadmap_lookup.h"
#include "common/world/reachability.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

constexpr double kInscribed = 0.025;  // of the paper's car

struct Maze {
  World world;
  DistanceField field;
  PlannerConfig config;

  explicit Maze(uint64_t seed) : world(MakeWorld(Config(seed))), field(world, WorldConfig{}.field_resolution) {}
  static WorldConfig Config(uint64_t seed) {
    WorldConfig config;
    config.seed = seed;
    return config;
  }
  BuiltRoadmap Build() const { return BuildRoadmap(world, field, config, kInscribed); }
};

std::string Message(const World& world, const PlannerConfig& config) {
  const DistanceField field(world, 0.01);
  try {
    BuildRoadmap(world, field, config, kInscribed);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(PlannerTest, SameConfigGivesTheSameBytesTwiceInOneProcess) {
  const Maze maze(1);
  const Roadmap a = maze.Build().roadmap, b = maze.Build().roadmap;
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.offsets, b.offsets);
  EXPECT_EQ(a.neighbors, b.neighbors);
  EXPECT_EQ(a.lengths, b.lengths);
  Maze other(1);
  other.config.seed = 2;
  EXPECT_NE(other.Build().roadmap.Hash(), a.Hash());
}

TEST(PlannerTest, MazeRoadmapIsOneComponentWithFreeEdges) {
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    const Maze maze(seed);
    const BuiltRoadmap built = maze.Build();
    const Roadmap& roadmap = built.roadmap;
    EXPECT_EQ(built.info.components, 1);
    EXPECT_EQ(built.info.vertices, roadmap.num_vertices());
    EXPECT_EQ(built.info.edges, roadmap.num_edges());
    EXPECT_GT(built.info.samples, built.info.vertices / 2);
    for (int v = 0; v < roadmap.num_vertices(); ++v) {
      for (int e = roadmap.offsets[v]; e < roadmap.offsets[v + 1]; ++e) {
        const Vector3d a = roadmap.position(v), b = roadmap.position(roadmap.neighbors[e]);
        if (roadmap.neighbors[e] < v) continue;
        const double least = LeastDistance(maze.world, a, b, 40);
        ASSERT_GE(least, maze.config.radius - 5e-6);
      }
    }
  }
}

// Against an own draw of free points, not the builder's.
TEST(PlannerTest, CoversFreeSpaceAsAsked) {
  const Maze maze(1);
  const BuiltRoadmap built = maze.Build();
  EXPECT_GE(built.info.coverage, 0.999);
  const CostTable table = ComputeCostTable(built.roadmap, maze.world, maze.world.goal);
  const RoadmapLookup lookup(2, built.roadmap.positions, table, maze.config.r_ball());
  RandomStream random(9, RandomPurpose::kTest);
  int free = 0, covered = 0;
  while (free < 20000) {
    const Vector3d p = DrawIn(maze.world, random);
    if (SignedDistance(maze.world, p) < maze.config.radius) continue;
    ++free;
    covered += std::isfinite(lookup.CostToGo(p));
  }
  EXPECT_GE(covered / 20000.0, 0.998);
}

// DESIGN 22: whatever vertex gives D(s) at a point where the robot can be, the straight line to it crosses no wall.
TEST(PlannerTest, CostsAreNeverReadThroughWalls) {
  const Maze maze(1);
  const Roadmap roadmap = maze.Build().roadmap;
  RandomStream random(10, RandomPurpose::kTest);
  int pairs = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d p = DrawIn(maze.world, random);
    if (SignedDistance(maze.world, p) < kInscribed) continue;
    for (int v = 0; v < roadmap.num_vertices(); ++v) {
      if ((roadmap.position(v) - p).norm() > maze.config.r_ball()) continue;
      ++pairs;
      ASSERT_GT(LeastDistance(maze.world, p, roadmap.position(v), 40), 0) << p.transpose();
    }
  }
  EXPECT_GT(pairs, 1000);
}

TEST(PlannerTest, CostsOfTheMazeAreNearThoseOfADenserRoadmap) {
  Maze maze(1);
  const Roadmap coarse = maze.Build().roadmap;
  const CostTable table = ComputeCostTable(coarse, maze.world, maze.world.goal);
  maze.config.min_spacing = 0.012;
  maze.config.seed = 5;
  const Roadmap dense = maze.Build().roadmap;
  const RoadmapLookup lookup(2, dense.positions, ComputeCostTable(dense, maze.world, maze.world.goal), 0.03);
  for (int v = 0; v < coarse.num_vertices(); ++v) {
    const float reference = lookup.CostToGo(coarse.position(v));
    if (!std::isfinite(reference)) continue;
    EXPECT_GE(table.cost[v], 0.99 * reference - 0.08);  // the lookup's ball and the goal's edge
    EXPECT_LE(table.cost[v], 1.25 * reference + 0.15);
  }
}

TEST(PlannerTest, SpaceWorldsWork) {
  const World world = TwoRooms(3);
  const DistanceField field(world, 0.01);
  PlannerConfig config;
  config.eta = 0.18;
  config.radius = 0.04;
  config.min_spacing = 0.06;
  config.coverage = 0.99;
  const BuiltRoadmap built = BuildRoadmap(world, field, config, 0.04);
  EXPECT_EQ(built.info.components, 1);
  EXPECT_GE(built.info.coverage, 0.99);
  for (const float c : ComputeCostTable(built.roadmap, world, world.goal).cost) EXPECT_TRUE(std::isfinite(c));
}

// The goal region reaches into both rooms of a world without a door: each needs its own root.
TEST(PlannerTest, AGoalOfTwoPartsIsEnteredInBoth) {
  World world = TwoRooms(2);
  world.boxes = {{Vector3d(1, 0, 0), Vector3d(1.05, 1, 0)}};
  world.goal = {Vector3d(0.9, 0.1, 0), Vector3d(1.2, 0.9, 0)};
  const DistanceField field(world, 0.01);
  const BuiltRoadmap built = BuildRoadmap(world, field, PlannerConfig{}, kInscribed);
  EXPECT_EQ(built.info.components, 2);
  for (const float c : ComputeCostTable(built.roadmap, world, world.goal).cost) EXPECT_TRUE(std::isfinite(c));
}

TEST(PlannerRejectTest, EtaThatReadsThroughWallsNamesTheLargestThatPasses) {
  PlannerConfig config;  // thinnest wall 0.05, radius 0.03, inscribed 0.025: eta < 0.21
  config.eta = 0.2101;
  EXPECT_THAT(Message(TwoRooms(2), config),
              testing::AllOf(testing::HasSubstr("planner.eta = 0.2101 m"), testing::HasSubstr("0.105 m"),
                             testing::HasSubstr("largest eta that passes is 0.2099 m")));
  config.eta = 0.2099;
  EXPECT_EQ(Message(TwoRooms(2), config), "");
}

// An imported map has no wall thickness to read from its boxes. Between two rooms that only a long way round joins, a
// vertex just behind the thin wall would look near.
TEST(PlannerRejectTest, CostsReadThroughTheWallOfAnImportedMapAreFoundBySampling) {
  World world;
  world.imported = true;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(2, 2, 0)};
  world.boxes = {{Vector3d(0, 1, 0), Vector3d(1.8, 1.01, 0)}};
  world.start = {Vector3d(0, 0, 0), Vector3d(0.3, 0.3, 0)};
  world.goal = {Vector3d(0, 1.7, 0), Vector3d(0.3, 2, 0)};
  PlannerConfig config;
  config.eta = 0.3;
  EXPECT_THAT(Message(world, config),
              testing::AllOf(testing::HasSubstr("planner.eta = 0.3 m: at ("), testing::HasSubstr("behind a wall"),
                             testing::HasSubstr("= 0.11 m is certain to pass")));
  config.eta = 0.1;
  EXPECT_EQ(Message(world, config), "");
  // What the boxes say would refuse this one, but nothing is read through a wall that stands alone.
  world.boxes = {{Vector3d(0.6, 1, 0), Vector3d(0.65, 1.01, 0)}};
  config.eta = 0.25;
  EXPECT_EQ(Message(world, config), "");
}

// Between two rooms that only a long way round joins: each obstacle alone is thick, what they make together is not.
TEST(PlannerRejectTest, CostsReadThroughWhereObstaclesTouchAreFoundBySampling) {
  World world;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(2, 2, 0)};
  world.start = {Vector3d(0, 0, 0), Vector3d(0.3, 0.3, 0)};
  world.goal = {Vector3d(0, 1.7, 0), Vector3d(0.3, 2, 0)};
  for (int i = 0; i < 10; ++i) world.cylinders.push_back({Vector3d(0.19 * i, 1, 0), 0.1, 0});
  PlannerConfig config;
  config.eta = 0.5;  // below 0.51, what the thinnest obstacle allows
  const auto refused = testing::AllOf(testing::HasSubstr(" m: at ("), testing::HasSubstr("behind a wall"),
                                      testing::HasSubstr("is certain to pass"));
  EXPECT_THAT(Message(world, config), refused);
  config.eta = 0.1;
  EXPECT_EQ(Message(world, config), "");

  world.cylinders.clear();  // boxes that touch at their corners
  for (int i = 0; i < 4; ++i)
    world.boxes.push_back({Vector3d(0.4 * i, 1 - 0.4 * (i % 2), 0), Vector3d(0.4 * i + 0.4, 1.4 - 0.4 * (i % 2), 0)});
  config.eta = 0.5;
  EXPECT_THAT(Message(world, config), refused);
  config.eta = 0.1;
  EXPECT_EQ(Message(world, config), "");
}

// Their thinnest obstacle is their thinnest wall: nothing is sampled.
TEST(PlannerTest, WallsOfMazesOverlap) {
  EXPECT_TRUE(Maze(1).world.walls_overlap);
  WorldConfig cube;
  cube.kind = WorldConfig::Kind::kCubeMaze;
  cube.wall_thickness = 0.01;
  EXPECT_TRUE(MakeWorld(cube).walls_overlap);
}

TEST(PlannerRejectTest, SpacingThatCannotCoverIsRefused) {
  PlannerConfig config;
  config.min_spacing = 0.051;
  EXPECT_THAT(Message(TwoRooms(2), config), testing::HasSubstr("planner.min_spacing = 0.051 m"));
}

TEST(PlannerRejectTest, GoalInsideAWallAndUnreachableGoalAreNamed) {
  World world = TwoRooms(2);
  world.goal = {Vector3d(1.01, 0.1, 0), Vector3d(1.04, 0.2, 0)};
  EXPECT_THAT(Message(world, PlannerConfig{}), testing::HasSubstr("world.goal [1.01, 1.04] × [0.1, 0.2] m: no point"));
  world = TwoRooms(2);
  PlannerConfig config;
  config.radius = 0.11;  // wider than the door
  EXPECT_THAT(Message(world, config), testing::HasSubstr("cannot be reached from world.start"));
}

TEST(PlannerRejectTest, SampleCapIsAnErrorWithTheCoverageReached) {
  PlannerConfig config;
  config.max_samples = 100;
  EXPECT_THAT(Message(TwoRooms(2), config), testing::HasSubstr("planner.max_samples = 100: reached with coverage 0."));
}

}  // namespace
}  // namespace cairn::planner
