#include "actors/vehicles/quadruped/leg.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cairn::actors {
namespace {

TEST(LegTest, StraightLegHangsDown) {
  const FootPosition foot = ForwardKinematics({0.04, 0.03}, {});
  EXPECT_NEAR(foot.x, 0, 1e-15);
  EXPECT_NEAR(foot.y, 0, 1e-15);
  EXPECT_NEAR(foot.z, -0.07, 1e-15);
}

// Thigh level to the front, shank hanging down.
TEST(LegTest, PositiveAnglesTurnBackwardsAndToTheLeft) {
  const double right = std::acos(0.0);
  const FootPosition front = ForwardKinematics({0.04, 0.03}, {0, -right, right});
  EXPECT_NEAR(front.x, 0.04, 1e-15);
  EXPECT_NEAR(front.z, -0.03, 1e-15);
  const FootPosition left = ForwardKinematics({0.04, 0.03}, {right, 0, 0});
  EXPECT_NEAR(left.y, 0.07, 1e-15);
  EXPECT_NEAR(left.z, 0, 1e-15);
}

TEST(LegTest, InverseReachesTheFootWithTheKneeBackwards) {
  const LegLengths lengths{0.04, 0.035};
  for (double x = -0.035; x <= 0.035; x += 0.005) {
    for (double y = -0.03; y <= 0.03; y += 0.005) {
      for (double z = -0.055; z <= -0.02; z += 0.005) {
        const LegAngles angles = InverseKinematics(lengths, {x, y, z});
        const FootPosition foot = ForwardKinematics(lengths, angles);
        ASSERT_NEAR(foot.x, x, 1e-12);
        ASSERT_NEAR(foot.y, y, 1e-12);
        ASSERT_NEAR(foot.z, z, 1e-12);
        ASSERT_LE(angles.knee, 0);
      }
    }
  }
}

TEST(LegTest, DrawsInWhatIsOutOfReach) {
  const LegLengths lengths{0.04, 0.04};
  const FootPosition foot = ForwardKinematics(lengths, InverseKinematics(lengths, {0.3, 0, -0.4}));
  EXPECT_NEAR(std::hypot(foot.x, foot.z), 0.98 * 0.08, 1e-12);
  EXPECT_NEAR(foot.x / foot.z, -0.75, 1e-12);
}

}  // namespace
}  // namespace cairn::actors
