#include "common/world/import/cell_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/core/random.h"
#include "tests/common/world/import/map_files.h"

namespace cairn {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr int64_t kMax = 1000000;

TEST(CellGridTest, MergesAlongXThenY) {
  const std::vector<Box> boxes = MergeBoxes(GridOf({"##.#",  //
                                                    "##..",  //
                                                    "####"},
                                                   0.5));
  ASSERT_EQ(boxes.size(), 3u);
  EXPECT_EQ(boxes[0].min, Vector3d(0, 0, 0));  // the whole lowest row
  EXPECT_EQ(boxes[0].max, Vector3d(2, 0.5, 0));
  EXPECT_EQ(boxes[1].min, Vector3d(0, 0.5, 0));
  EXPECT_EQ(boxes[1].max, Vector3d(1, 1.5, 0));
  EXPECT_EQ(boxes[2].min, Vector3d(1.5, 1, 0));
}

// Each cell that is not free lies in exactly one box, and no other does.
TEST(CellGridTest, MergedBoxesCoverTheCellsOnceInPlaneAndSpace) {
  RandomStream random(1, RandomPurpose::kTest);
  for (const int dimension : {2, 3}) {
    CellGrid grid;
    grid.dimension = dimension;
    grid.size = {17, 13, dimension == 3 ? 9 : 1};
    grid.cell = 0.25;
    grid.origin = {-1, 2, dimension == 3 ? 0.5 : 0};
    for (int i = 0; i < grid.size.prod(); ++i) grid.cells.push_back(static_cast<Cell>(random.Below(4) % 3));
    const std::vector<Box> boxes = MergeBoxes(grid);
    int occupied = 0;
    for (int z = 0; z < grid.size.z(); ++z) {
      for (int y = 0; y < grid.size.y(); ++y) {
        for (int x = 0; x < grid.size.x(); ++x) {
          const Vector3d p = grid.origin + grid.cell * Vector3d(x + 0.5, y + 0.5, dimension == 3 ? z + 0.5 : 0);
          const auto holds = [&](const Box& box) {
            return (p.array() >= box.min.array()).all() && (p.array() <= box.max.array()).all();
          };
          const bool taken = grid.cells[grid.Index(x, y, z)] != Cell::kFree;
          ASSERT_EQ(std::count_if(boxes.begin(), boxes.end(), holds), taken ? 1 : 0) << p.transpose();
          occupied += taken;
        }
      }
    }
    EXPECT_LT(static_cast<int>(boxes.size()), occupied);
  }
}

TEST(CellGridTest, CropsToTheFreeCellsAndTheirMargin) {
  const CellGrid cropped = CropToFree(GridOf({"??????",  //
                                              "??##??",  //
                                              "??#.??",  //
                                              "??????",  //
                                              "??????"}),
                                      std::nullopt, 1, "f");
  EXPECT_THAT(Rows(cropped), ElementsAre("##?", "#.?", "???"));
  EXPECT_EQ(cropped.origin, Vector3d(2, 1, 0));
}

TEST(CellGridTest, AWindowIsWidenedToWholeCells) {
  const CellGrid grid = GridOf({".....", ".....", "....."}, 0.5);
  const CellGrid cropped = CropToFree(grid, Box{Vector3d(0.6, 0, 0), Vector3d(1.9, 0.9, 0)}, 1, "f");
  EXPECT_EQ(cropped.size, Eigen::Vector3i(3, 2, 1));
  EXPECT_EQ(cropped.origin, Vector3d(0.5, 0, 0));
  EXPECT_THAT(ErrorOf([&] {
                CropToFree(grid, Box{Vector3d(9, 9, 0), Vector3d(10, 10, 0)}, 1, "f");
              }),
              HasSubstr("f: no cell is free within world.bounds"));
}

TEST(CellGridTest, AWindowWithoutHeightsTakesThemAll) {
  CellGrid grid;
  grid.dimension = 3;
  grid.size = {4, 3, 5};
  grid.cell = 0.5;
  grid.origin = {0, 0, 1};
  grid.cells.assign(60, Cell::kFree);
  const CellGrid all = CropToFree(grid, Box{Vector3d(0, 0, 0), Vector3d(1, 1, 0)}, 1, "f");
  EXPECT_EQ(all.size, Eigen::Vector3i(2, 2, 5));
  EXPECT_EQ(all.origin, Vector3d(0, 0, 1));
  EXPECT_EQ(CropToFree(grid, Box{Vector3d(0, 0, 1.5), Vector3d(1, 1, 2)}, 1, "f").size, Eigen::Vector3i(2, 2, 1));
}

TEST(CellGridTest, NothingFreeIsAnErrorWithItsCure) {
  EXPECT_THAT(ErrorOf([] { CropToFree(GridOf({"#?"}), std::nullopt, 1, "a.yaml"); }),
              HasSubstr("a.yaml: no cell is free; if free cells were saved as unknown, set world.unknown_is_free"));
}

TEST(CellGridTest, QuarterTurnsAreExact) {
  CellGrid grid = GridOf({"#.?",  //
                          "..#"});
  grid.origin = {10, 20, 0};
  const CellGrid left = Rotate(grid, 0.5 * std::numbers::pi, "f", kMax);  // x becomes y
  EXPECT_THAT(Rows(left), ElementsAre("?#", "..", "#."));
  EXPECT_TRUE(left.origin.isApprox(Vector3d(8, 20, 0)));
  const CellGrid half = Rotate(grid, -std::numbers::pi, "f", kMax);
  EXPECT_THAT(Rows(half), ElementsAre("#..", "?.#"));
  EXPECT_TRUE(half.origin.isApprox(Vector3d(7, 18, 0)));
  const CellGrid right = Rotate(grid, 1.5 * std::numbers::pi, "f", kMax);
  EXPECT_THAT(Rows(right), ElementsAre(".#", "..", "#?"));
  EXPECT_TRUE(right.origin.isApprox(Vector3d(10, 17, 0)));
}

// What is free after a turn was free before, and an obstacle reaches no farther than one cell of the map.
TEST(CellGridTest, OtherTurnsAreSafeAndGrowObstaclesByLessThanACell) {
  CellGrid grid;
  grid.size = {40, 30, 1};
  grid.cell = 0.1;
  grid.origin = {1, -2, 0};
  RandomStream random(2, RandomPurpose::kTest);
  for (int i = 0; i < 1200; ++i) grid.cells.push_back(random.Below(20) == 0 ? Cell::kOccupied : Cell::kFree);
  for (const double yaw : {0.3, -1.1, 2.7}) {
    const CellGrid turned = Rotate(grid, yaw, "f", kMax);
    EXPECT_DOUBLE_EQ(turned.cell, 0.05);
    const double c = std::cos(yaw), s = std::sin(yaw);
    int free = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vector3d p = turned.origin + Vector3d(random.Uniform(0, turned.cell * turned.size.x()),
                                                  random.Uniform(0, turned.cell * turned.size.y()), 0);
      const Eigen::Vector3i cell = ((p - turned.origin) / turned.cell).cast<int>();
      const Vector3d d = p - grid.origin;
      const double u = (c * d.x() + s * d.y()) / grid.cell, v = (c * d.y() - s * d.x()) / grid.cell;  // in map cells
      double nearest = 1e9;  // to an occupied cell or the outside [cells]
      for (int y = -1; y <= 30; ++y) {
        for (int x = -1; x <= 40; ++x) {
          const bool inside = x >= 0 && y >= 0 && x < 40 && y < 30;
          if (inside && grid.cells[grid.Index(x, y)] == Cell::kFree) continue;
          nearest = std::min(nearest, std::hypot(std::max({x - u, u - x - 1, 0.0}), std::max({y - v, v - y - 1, 0.0})));
        }
      }
      const bool is_free = turned.cells[turned.Index(cell.x(), cell.y())] == Cell::kFree;
      if (is_free) {
        ASSERT_GT(nearest, 0) << p.transpose();
      }
      if (nearest > 1 && u > 0 && v > 0 && u < 40 && v < 30) {
        ASSERT_TRUE(is_free) << p.transpose();
      }
      free += is_free;
    }
    EXPECT_GT(free, 3000);
  }
}

TEST(CellGridTest, HeadersThatPromiseTooMuchAreRefusedByTheirFigures) {
  const auto check = [](const Vector3d& sizes, double cell, const Vector3d& origin) {
    return ErrorOf([&] { CheckGrid("m.pgm", sizes, cell, origin, kMax); });
  };
  EXPECT_EQ(check({1000, 1000, 1}, 0.05, {0, 0, 0}), "");
  EXPECT_THAT(check({1e9, 1e9, 1}, 0.05, {0, 0, 0}),
              HasSubstr("m.pgm: x from 0 to 50000000 m (1000000000 cells of 0.05"));
  EXPECT_THAT(check({1001, 1000, 1}, 0.05, {0, 0, 0}), HasSubstr("1001 x 1000 x 1 cells are more than 1000000"));
  EXPECT_THAT(check({10, 10, 1}, 50, {0, 0, 0}), HasSubstr("resolution = 50 m a cell"));
  EXPECT_THAT(check({10, 10, 1}, 0, {0, 0, 0}), HasSubstr("resolution = 0 m a cell"));
  EXPECT_THAT(check({10, 10, 1}, std::nan(""), {0, 0, 0}), HasSubstr("resolution = nan m a cell"));
  EXPECT_THAT(check({10, 10, 1}, 0.05, {500000, 4649776, 0}), HasSubstr("subtract an offset from the origin"));
  EXPECT_THAT(check({0, 10, 1}, 0.05, {0, 0, 0}), HasSubstr("0 x 10 cells"));
}

}  // namespace
}  // namespace cairn
