#include "actors/clearance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const Footprint kCar{0.035, 0.025};

class ClearanceTest : public ::testing::Test {
 protected:
  // A thin post that can stand between the corners of a footprint, and the hall's walls.
  ClearanceTest() : world_(MakeWorld(Config())), field_(world_, 0.002) {}

  static WorldConfig Config() {
    WorldConfig config = HallExperiment().world;
    config.obstacles = {{{1.499, 0.499, 0}, {1.501, 0.501, 0}}};
    return config;
  }

  double Clearance(double x, double y, double yaw, double upper = kInfinity) const {
    return FootprintClearance(field_, {x, y, yaw}, kCar, field_.Distance(Vector3d(x, y, 0)), upper);
  }

  World world_;
  DistanceField field_;
};

TEST_F(ClearanceTest, IsTheGapBesideAndAheadOfTheFootprint) {
  EXPECT_NEAR(Clearance(0.5, 0.075, 0), 0.05, 0.003);
  EXPECT_NEAR(Clearance(0.5, 0.075, M_PI / 2), 0.04, 0.003);
  EXPECT_NEAR(Clearance(0.5, 0.1, M_PI / 4), 0.1 - (0.035 + 0.025) / std::sqrt(2), 0.003);
}

// 5 mm beside the middle of the long side, 35 mm from the corners.
TEST_F(ClearanceTest, SeesAPostBetweenTheCorners) {
  EXPECT_NEAR(Clearance(1.5, 0.501 + 0.025 + 0.005, 0), 0.005, 0.003);
  EXPECT_NEAR(Clearance(1.51, 0.501 + 0.025 + 0.010, 0), 0.010, 0.003);
  EXPECT_NEAR(Clearance(1.501 + 0.035 + 0.004, 0.51, 0), 0.004, 0.003);
}

TEST_F(ClearanceTest, NeverExceedsTheUpperBoundAndNeverFallsBelowZero) {
  EXPECT_EQ(Clearance(0.5, 0.5, 0, 0.01), 0.01);
  EXPECT_NEAR(Clearance(0.5, 0.075, 0, 0.06), 0.05, 0.003);
  EXPECT_EQ(Clearance(0.5, 0.01, 0), 0);
}

}  // namespace
}  // namespace cairn::actors
