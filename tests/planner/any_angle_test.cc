#include "tests/planner/any_angle.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cairn::planner {
namespace {

constexpr double kRadius = 0.1;

// A wall from below that ends at y = 1; the goal is a strip at the right, 2.5 m ≤ x ≤ 3 m.
World OneWall(int dimension) {
  World world;
  world.dimension = dimension;
  const double top = dimension == 3 ? 1 : 0;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(3, 2, top)};
  world.boxes = {{Vector3d(1, 0, 0), Vector3d(1.2, 1, top)}};
  world.goal = {Vector3d(2.5, 0.2, 0), Vector3d(3, 0.4, top)};
  return world;
}

// Over the wall's left and right corner and down to the strip's upper left corner: tangent, arc, along the wall's end,
// arc, tangent. From (0.5, 0.5) the tangent to the arc around (1, 1) rises by atan(1) + asin(0.1 / (0.5 √2)); to
// (2.5, 0.4) the one around (1.2, 1) falls by atan(0.6 / 1.3) + asin(0.1 / √(0.6² + 1.3²)).
double Expected() {
  const double near = 0.5 * std::sqrt(2.0), far = std::hypot(0.6, 1.3);
  const double rise = std::atan(1.0) + std::asin(kRadius / near),
               fall = std::atan2(0.6, 1.3) + std::asin(kRadius / far);
  return std::sqrt(near * near - kRadius * kRadius) + std::sqrt(far * far - kRadius * kRadius) + 0.2 +
         kRadius * (rise + fall);
}

TEST(PlaneTruthTest, WaysBendAroundRoundedCorners) {
  const PlaneTruth truth(OneWall(2), kRadius);
  const double length = truth.Length(Vector3d(0.5, 0.5, 0));
  EXPECT_GE(length, Expected() - 1e-5);
  EXPECT_LE(length, Expected() + 0.004 * kRadius * 2);         // of both arcs, at most a quarter each
  EXPECT_NEAR(truth.Length(Vector3d(2, 0.3, 0)), 0.5, 1e-12);  // straight into the goal region
  EXPECT_NEAR(truth.Length(Vector3d(2.2, 0.8, 0)), 0.5, 1e-12);
  EXPECT_EQ(truth.Length(Vector3d(2.6, 0.3, 0)), 0);
}

TEST(PlaneTruthTest, WaysBendAroundDiscs) {
  World world = OneWall(2);
  world.boxes.clear();
  world.cylinders = {{Vector3d(1.5, 0.3, 0), 0.4, 0}};
  world.goal = {Vector3d(2.5, 0.3, 0), Vector3d(2.5, 0.3, 0)};
  // Symmetric: two tangents of length √(1 − 0.5²) and an arc of π − 2 acos(0.5) at 0.5 m around the centre.
  const double expected = 2 * std::sqrt(0.75) + 0.5 * (std::acos(-1.0) - 2 * std::acos(0.5));
  EXPECT_NEAR(PlaneTruth(world, kRadius).Length(Vector3d(0.5, 0.3, 0)), expected, 0.002);
}

TEST(PlaneTruthTest, ThereIsNoWayThroughAGapThatIsTooNarrow) {
  World world = OneWall(2);
  world.boxes.push_back({Vector3d(1, 1.19, 0), Vector3d(1.2, 2, 0)});
  EXPECT_TRUE(std::isinf(PlaneTruth(world, kRadius).Length(Vector3d(0.5, 0.5, 0))));
  world.boxes.back().min.y() = 1.21;
  EXPECT_TRUE(std::isfinite(PlaneTruth(world, kRadius).Length(Vector3d(0.5, 0.5, 0))));
}

// The wall reaches from floor to ceiling, so the shortest way is the plane's.
TEST(SpaceTruthTest, ComesNearTheShortestWayOnACoarseGrid) {
  const SpaceTruth truth(OneWall(3), kRadius, 0.1);
  const double length = truth.Length(Vector3d(0.5, 0.5, 0.5));
  EXPECT_GE(length, Expected() - 1e-5);
  EXPECT_LE(length, 1.004 * Expected());
  EXPECT_NEAR(truth.Length(Vector3d(2, 0.3, 0.5)), 0.5, 1e-12);
}

TEST(StraightWaysTest, GrazingIsClearAndTouchingIsNot) {
  const StraightWays ways(OneWall(3), kRadius);
  const auto clear = [&](double y) { return ways.Clear(Vector3d(0.5, y, 0.5), Vector3d(2, y, 0.5)); };
  EXPECT_TRUE(clear(1.1));
  EXPECT_FALSE(clear(1.0999));
  EXPECT_FALSE(ways.Clear(Vector3d(0.5, 1.2, 0.5), Vector3d(0.5, 1.2, 0.95)));  // the bounds
  EXPECT_FALSE(ways.Clear(Vector3d(0.5, 0.5, 0.5), Vector3d(2, 0.5, 0.5)));     // through the wall
}

}  // namespace
}  // namespace cairn::planner
