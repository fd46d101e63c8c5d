#include "planner/color_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace cairn::planner {
namespace {

TEST(ColorMapTest, RunsFromYellowToPurpleAndClamps) {
  EXPECT_EQ(CostColor(0), "#fde725");
  EXPECT_EQ(CostColor(1), "#440154");
  EXPECT_EQ(CostColor(-3), CostColor(0));
  EXPECT_EQ(CostColor(3), CostColor(1));
}

// Relative luminance falls all the way, so that the scale reads in grey too.
TEST(ColorMapTest, GetsDarkerAllTheWay) {
  double last = 2;
  for (int i = 0; i <= 100; ++i) {
    const std::string color = CostColor(i / 100.0);
    double luminance = 0;
    const double weights[3] = {0.2126, 0.7152, 0.0722};
    for (int k = 0; k < 3; ++k) {
      const double c = std::strtol(color.substr(1 + 2 * k, 2).c_str(), nullptr, 16) / 255.0;
      luminance += weights[k] * std::pow(c, 2.2);
    }
    EXPECT_LT(luminance, last) << i;
    last = luminance;
  }
}

}  // namespace
}  // namespace cairn::planner
