#include "common/world/cell_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/core/random.h"
#include "common/world/distance_field.h"
#include "common/world/import/cell_grid.h"

namespace cairn {
namespace {

// A world of random cells, a fifth of them occupied, with solid blocks among them.
struct Cells {
  CellGrid grid;
  World world;

  explicit Cells(int dimension) {
    RandomStream random(1, RandomPurpose::kTest);
    grid.dimension = dimension;
    grid.size = dimension == 3 ? Eigen::Vector3i(12, 9, 7) : Eigen::Vector3i(23, 17, 1);
    grid.cell = 0.3;
    grid.origin = {-2, 1, dimension == 3 ? 0.7 : 0};
    for (int i = 0; i < grid.size.prod(); ++i)
      grid.cells.push_back(random.Below(5) == 0 ? Cell::kOccupied : Cell::kFree);
    for (int z = 0; z < std::min(5, grid.size.z()); ++z) {
      for (int y = 2; y < 8; ++y) {
        for (int x = 3; x < 9; ++x) grid.cells[grid.Index(x, y, z)] = Cell::kOccupied;
      }
    }
    world.dimension = dimension;
    world.imported = true;
    world.bounds.min = grid.origin;
    for (int k = 0; k < dimension; ++k) world.bounds.max[k] = grid.origin[k] + grid.cell * grid.size[k];
    world.boxes = MergeBoxes(grid);
  }

  // Distance to the nearest cell that is (not) free, over all of them; what is outside is occupied.
  double Nearest(const Vector3d& p, bool free) const {
    double nearest = 1e9;
    const int low_z = world.dimension == 3 ? -1 : 0, high_z = world.dimension == 3 ? grid.size.z() : 0;
    for (int z = low_z; z <= high_z; ++z) {
      for (int y = -1; y <= grid.size.y(); ++y) {
        for (int x = -1; x <= grid.size.x(); ++x) {
          const bool inside = x >= 0 && y >= 0 && z >= 0 && x < grid.size.x() && y < grid.size.y() && z < grid.size.z();
          const bool is_free = inside && grid.cells[grid.Index(x, y, z)] == Cell::kFree;
          if (is_free != free) continue;
          const Vector3d low = grid.origin + grid.cell * Vector3d(x, y, z);
          Vector3d d = Vector3d::Zero();
          for (int k = 0; k < world.dimension; ++k) d[k] = std::max({low[k] - p[k], p[k] - low[k] - grid.cell, 0.0});
          nearest = std::min(nearest, d.norm());
        }
      }
    }
    return nearest;
  }
};

class CellDistanceTest : public testing::TestWithParam<int> {};

TEST_P(CellDistanceTest, IsExactAtNodesInsideAndOut) {
  const Cells cells(GetParam());
  const double resolution = 0.15;
  Eigen::Vector3i nodes(1, 1, 1);
  for (int k = 0; k < GetParam(); ++k) nodes[k] = 2 * cells.grid.size[k] + 1;
  const std::vector<float> distances = CellDistances(cells.world, resolution, nodes);
  ASSERT_EQ(distances.size(), static_cast<size_t>(nodes.prod()));
  int inside = 0;
  size_t i = 0;
  for (int z = 0; z < nodes.z(); ++z) {
    for (int y = 0; y < nodes.y(); ++y) {
      for (int x = 0; x < nodes.x(); ++x, ++i) {
        const Vector3d p = cells.grid.origin + resolution * Vector3d(x, y, z);
        const double outside = cells.Nearest(p, false);
        ASSERT_NEAR(distances[i], outside > 1e-9 ? outside : -cells.Nearest(p, true), 1e-5) << p.transpose();
        inside += distances[i] < 0;
      }
    }
  }
  EXPECT_GT(inside, 20);
}

TEST_P(CellDistanceTest, WhatDoesNotLieOnNodesIsLeftToOthers) {
  Cells cells(GetParam());
  Eigen::Vector3i nodes(1, 1, 1);
  for (int k = 0; k < GetParam(); ++k) nodes[k] = cells.grid.size[k] + 1;
  EXPECT_FALSE(CellDistances(cells.world, 0.3, nodes).empty());
  EXPECT_TRUE(CellDistances(cells.world, 0.29, nodes).empty());
  cells.world.boxes[0].max.x() += 0.01;
  EXPECT_TRUE(CellDistances(cells.world, 0.3, nodes).empty());
  cells = Cells(GetParam());
  cells.world.cylinders.push_back({Vector3d(0, 2, 1), 0.1, 0.1});
  EXPECT_TRUE(CellDistances(cells.world, 0.3, nodes).empty());
}

// Both ways to fill a field agree wherever there is free space.
TEST_P(CellDistanceTest, FieldsOfImportedMapsAreTheOthersOutsideObstacles) {
  Cells cells(GetParam());
  const DistanceField fast(cells.world, 0.15);
  cells.world.imported = false;
  const DistanceField slow(cells.world, 0.15);
  RandomStream random(2, RandomPurpose::kTest);
  for (int i = 0; i < 5000; ++i) {
    Vector3d p = Vector3d::Zero();
    for (int k = 0; k < GetParam(); ++k) p[k] = random.Uniform(cells.world.bounds.min[k], cells.world.bounds.max[k]);
    if (slow.Distance(p) < 0.15) continue;  // nodes beside it may lie inside, where depths differ
    ASSERT_NEAR(fast.Distance(p), slow.Distance(p), 1e-5) << p.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(PlaneAndSpace, CellDistanceTest, testing::Values(2, 3));

}  // namespace
}  // namespace cairn
