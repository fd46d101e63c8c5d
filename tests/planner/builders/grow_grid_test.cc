#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/core/check.h"
#include "common/world/import/cell_grid.h"
#include "planner/planner.h"
#include "tests/planner/brute_force.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

// A map as ImportMap makes a world of one; the goal is the free cell nearest to the middle.
World WorldOf(const CellGrid& grid) {
  World world;
  world.dimension = grid.dimension;
  world.imported = true;
  for (int k = 0; k < grid.dimension; ++k) world.bounds.max[k] = grid.cell * grid.size[k];
  world.boxes = MergeBoxes(grid);
  world.start = world.start_space = world.bounds;
  return world;
}

PlannerConfig GridConfig(const CellGrid& grid, double radius) {
  PlannerConfig config;
  config.kind = PlannerConfig::Kind::kGrid;
  config.grid_cell = grid.cell;
  config.grid_neighbors = grid.dimension == 3 ? 26 : 8;
  config.radius = radius;
  config.eta = 0.2;  // nothing is read through walls
  config.coverage = 1e-6;
  return config;
}

// Every cost of the roadmap, and which cells have one, against the brute force over `free`.
void ExpectBruteForceCosts(const CellGrid& grid, const World& world, const PlannerConfig& config, size_t goal,
                           const std::function<bool(int, int, int)>& free) {
  const DistanceField field(world, 0.25 * grid.cell);
  const Roadmap roadmap = BuildRoadmap(world, field, config, 0.05).roadmap;
  const CostTable table = ComputeCostTable(roadmap, world, world.goal);
  const bool diagonal = config.grid_neighbors > 6;
  const std::vector<double> lengths = BruteForceLengths(grid.size, diagonal, {goal}, free);
  size_t reached = 0;
  for (const double length : lengths) reached += std::isfinite(length);
  ASSERT_EQ(static_cast<size_t>(roadmap.num_vertices()), reached);
  for (int v = 0; v < roadmap.num_vertices(); ++v) {
    const Eigen::Vector3i cell = (roadmap.position(v) / grid.cell).array().floor().cast<int>();
    const double expected = grid.cell * lengths[grid.Index(cell.x(), cell.y(), grid.dimension == 3 ? cell.z() : 0)];
    ASSERT_NEAR(table.cost[v], expected, 2e-5 * (1 + expected));
  }
}

size_t GoalCell(const CellGrid& grid, World* world, const std::function<bool(int, int, int)>& free) {
  for (int y = grid.size.y() / 2;; ++y) {
    const int x = grid.size.x() / 2, z = grid.size.z() / 2;
    if (!free(x, y, z)) continue;
    const Vector3d center = grid.cell * (Vector3d(x, y, z).array() + 0.5).matrix();
    for (int k = 0; k < grid.dimension; ++k) {
      world->goal.min[k] = center[k] - 0.3 * grid.cell;
      world->goal.max[k] = center[k] + 0.3 * grid.cell;
    }
    return grid.Index(x, y, z);
  }
}

class GrowGridTest : public testing::TestWithParam<int> {
 protected:
  static CellGrid Cells(uint64_t seed) {
    return GetParam() > 8 || GetParam() == 6 ? RandomCells({9, 10, 8}, 0.15, seed)
                                             : RandomCells({31, 24, 1}, 0.2, seed);
  }
};

// A robot that is smaller than a cell: its cells are the map's.
TEST_P(GrowGridTest, CostsOfASmallRobotAreTheMapsShortestWays) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const CellGrid grid = Cells(seed);
    World world = WorldOf(grid);
    PlannerConfig config = GridConfig(grid, 0.3);
    config.grid_neighbors = GetParam();
    const auto free = [&](int x, int y, int z) {
      return x >= 0 && y >= 0 && z >= 0 && x < grid.size.x() && y < grid.size.y() && z < grid.size.z() &&
             grid.cells[grid.Index(x, y, z)] == Cell::kFree;
    };
    const size_t goal = GoalCell(grid, &world, free);
    ExpectBruteForceCosts(grid, world, config, goal, free);
  }
}

// A robot of some cells: a cell is free when its centre is that far from every obstacle and from the edge.
TEST_P(GrowGridTest, CostsOfALargeRobotAreThoseOfTheInflatedMap) {
  const bool space = GetParam() > 8 || GetParam() == 6;
  const CellGrid grid = space ? RandomCells({12, 12, 11}, 0.006, 5) : RandomCells({60, 50, 1}, 0.02, 3);
  World world = WorldOf(grid);
  PlannerConfig config = GridConfig(grid, 1.27);
  config.grid_neighbors = GetParam();
  const auto free = [&](int x, int y, int z) {
    if (z < 0 || z >= grid.size.z()) return false;
    return SignedDistance(world, Vector3d(x + 0.5, y + 0.5, space ? z + 0.5 : 0)) > config.radius;
  };
  const size_t goal = GoalCell(grid, &world, free);
  ExpectBruteForceCosts(grid, world, config, goal, free);
}

INSTANTIATE_TEST_SUITE_P(Neighbors, GrowGridTest, testing::Values(4, 8, 6, 26));

std::string Message(const World& world, const PlannerConfig& config) {
  const DistanceField field(world, 0.01);
  try {
    BuildRoadmap(world, field, config, 0.025);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

// Beside walls, a cell whose diagonal is eta covers too little, and half of it enough.
TEST(GrowGridRejectTest, WhatIsTriedInThePlaceOfACellThatDoesNotCoverCovers) {
  const CellGrid grid = RandomCells({16, 12, 1}, 0.04, 1);
  World world = WorldOf(grid);
  world.goal = world.bounds;
  PlannerConfig config = GridConfig(grid, 0.74);
  config.eta = 1.42;
  config.min_spacing = 0;
  config.coverage = 0.999;
  EXPECT_THAT(Message(world, config), testing::AllOf(testing::HasSubstr("planner.grid_cell = 1 m: cells cover 0."),
                                                     testing::HasSubstr("try 0.5 m")));
  config.grid_cell = 0.5;
  EXPECT_EQ(Message(world, config), "");
}

TEST(GrowGridRejectTest, CellsThatDoNotCoverFreeSpaceAreNamedWithSmallerOnes) {
  PlannerConfig config;
  config.kind = PlannerConfig::Kind::kGrid;
  config.grid_cell = 0.12;  // half a diagonal is 0.085 m, r_ball 0.05 m
  EXPECT_THAT(Message(TwoRooms(2), config),
              testing::AllOf(testing::HasSubstr("planner.grid_cell = 0.12 m: cells cover 0."),
                             testing::HasSubstr("try 0.03536 m")));
}

TEST(GrowGridRejectTest, TooManyCellsAndAGoalBetweenCellsAreNamed) {
  PlannerConfig config;
  config.kind = PlannerConfig::Kind::kGrid;
  config.grid_cell = 1e-4;
  EXPECT_THAT(Message(TwoRooms(2), config), testing::AllOf(testing::HasSubstr("planner.grid_cell = 0.0001 m: 2e+08"),
                                                           testing::HasSubstr("must be at least 0.000123 m")));
  World world = TwoRooms(2);
  world.goal = {Vector3d(1.701, 0.701, 0), Vector3d(1.71, 0.71, 0)};
  config.grid_cell = 0.04;
  EXPECT_THAT(Message(world, config), testing::HasSubstr("planner.grid_cell = 0.04 m: no cell's centre in world.goal"));
}

TEST(GrowGridRejectTest, NeighborsOfTheOtherDimensionAreRefused) {
  PlannerConfig config;
  config.kind = PlannerConfig::Kind::kGrid;
  config.grid_neighbors = 26;
  EXPECT_THAT(Message(TwoRooms(2), config), testing::HasSubstr("planner.grid_neighbors = 26: must be 4 or 8"));
}

}  // namespace
}  // namespace cairn::planner
