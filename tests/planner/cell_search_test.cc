#include "planner/cell_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/world/import/moving_ai.h"
#include "tests/planner/brute_force.h"

namespace cairn::planner {
namespace {

CellGrid Map(const std::string& rows, int width, int height) {
  const std::string text =
      "type octile\nheight " + std::to_string(height) + "\nwidth " + std::to_string(width) + "\nmap\n" + rows;
  return ReadMovingAi(text, "test.map", 1, 1000);
}

TEST(CellSearchTest, AgreesWithBruteForceOnRandomMaps) {
  for (const auto& [size, neighbors] : {std::pair{Eigen::Vector3i(23, 17, 1), 8},
                                        {Eigen::Vector3i(23, 17, 1), 4},
                                        {Eigen::Vector3i(9, 8, 7), 26},
                                        {Eigen::Vector3i(9, 8, 7), 6}}) {
    for (uint64_t seed = 1; seed <= 5; ++seed) {
      const CellGrid grid = RandomCells(size, 0.25, seed);
      CellSearch search(grid, neighbors);
      const auto free = [&](int x, int y, int z) { return search.Free({x, y, z}); };
      const Eigen::Vector3i middle = size / 2;
      if (!search.Free(middle)) continue;
      const size_t source = grid.Index(middle.x(), middle.y(), middle.z());
      const std::vector<double> lengths = BruteForceLengths(size, neighbors == 8 || neighbors == 26, {source}, free);
      for (int z = 0; z < size.z(); ++z) {
        for (int y = 0; y < size.y(); ++y) {
          for (int x = 0; x < size.x(); ++x) {
            const auto length = search.Length({x, y, z}, middle);
            const double expected = lengths[grid.Index(x, y, z)];
            ASSERT_EQ(length.has_value(), std::isfinite(expected));
            if (length) {
              ASSERT_NEAR(*length, expected, 1e-9);
            }
          }
        }
      }
    }
  }
}

TEST(CellSearchTest, NoCornerIsCut) {
  const CellGrid grid = Map("..\n@.\n", 2, 2);
  CellSearch search(grid, 8);
  EXPECT_DOUBLE_EQ(*search.Length({0, 1, 0}, {1, 0, 0}), 2);
  const CellGrid open = Map("..\n..\n", 2, 2);
  EXPECT_DOUBLE_EQ(*CellSearch(open, 8).Length({0, 1, 0}, {1, 0, 0}), std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(*CellSearch(open, 4).Length({0, 1, 0}, {1, 0, 0}), 2);
}

TEST(CellSearchTest, SaysWhenThereIsNoWay) {
  const CellGrid grid = Map(".@.\n.@.\n", 3, 2);
  CellSearch search(grid, 8);
  EXPECT_FALSE(search.Length({0, 0, 0}, {2, 0, 0}));
  EXPECT_FALSE(search.Length({0, 0, 0}, {1, 0, 0}));  // not free
  EXPECT_DOUBLE_EQ(*search.Length({0, 0, 0}, {0, 0, 0}), 0);
  EXPECT_DOUBLE_EQ(*search.Length({0, 0, 0}, {0, 1, 0}), 1);
}

}  // namespace
}  // namespace cairn::planner
