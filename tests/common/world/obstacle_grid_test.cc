#include "common/world/obstacle_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/core/random.h"
#include "common/world/signed_distance.h"

namespace cairn {
namespace {

World TestWorld() {
  World world = MakeCarMaze(WorldConfig{});
  world.cylinders = {{Vector3d(0.49, 0.41, 0), 0.03, 0}, {Vector3d(1.4, 0.2, 0), 0.01, 0}};
  // Away from the origin, so that offsets are tested too.
  const Vector3d shift(-3, 5, 0);
  for (Box* box : {&world.bounds, &world.start, &world.goal}) *box = {box->min + shift, box->max + shift};
  for (Box& box : world.boxes) box = {box.min + shift, box.max + shift};
  for (Cylinder& cylinder : world.cylinders) cylinder.base += shift;
  return world;
}

constexpr Footprint kCar{0.035, 0.025};

// Smallest signed distance over a fine lattice of the footprint's edge and a coarse one inside: negative means overlap,
// and an overlap can be missed only when it is thinner than the edge's lattice.
double EdgeDistance(const World& world, double x, double y, double yaw) {
  constexpr int kSteps = 70;
  double least = 1e300;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      if (i % kSteps != 0 && j % kSteps != 0 && (i % 10 != 0 || j % 10 != 0)) continue;
      const double u = kCar.half_length * (2.0 * i / kSteps - 1), v = kCar.half_width * (2.0 * j / kSteps - 1);
      const Vector3d p(x + std::cos(yaw) * u - std::sin(yaw) * v, y + std::sin(yaw) * u + std::cos(yaw) * v, 0);
      least = std::min(least, SignedDistance(world, p));
    }
  }
  return least;
}

TEST(ObstacleGridTest, OverlapAgreesWithSampledFootprints) {
  const World world = TestWorld();
  const ObstacleGrid grid(world, 0.044);
  RandomStream random(1, RandomPurpose::kTest);
  int overlaps = 0, free = 0;
  for (int i = 0; i < 1000; ++i) {
    const double x = random.Uniform(world.bounds.min.x() - 0.02, world.bounds.max.x() + 0.02);
    const double y = random.Uniform(world.bounds.min.y() - 0.02, world.bounds.max.y() + 0.02);
    const double yaw = random.Uniform(-4, 4);
    const double least = EdgeDistance(world, x, y, yaw);
    const bool overlap = grid.Overlaps(x, y, yaw, kCar);
    ASSERT_TRUE(overlap || least >= 0) << x << ", " << y << ", " << yaw;
    ASSERT_TRUE(!overlap || least <= 1.1e-3) << x << ", " << y << ", " << yaw;  // beyond the lattice's step
    overlaps += least < 0;
    free += least > 1.1e-3;
  }
  EXPECT_GT(overlaps, 300);
  EXPECT_GT(free, 100);
}

TEST(ObstacleGridTest, AnObstacleInsideTheFootprintOverlaps) {
  World world;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(1, 1, 0)};
  world.boxes = {{Vector3d(0.501, 0.501, 0), Vector3d(0.503, 0.503, 0)}};
  world.cylinders = {{Vector3d(0.2, 0.2, 0), 0.001, 0}};
  const ObstacleGrid grid(world, 0.05);
  EXPECT_TRUE(grid.Overlaps(0.5, 0.5, 0.3, kCar));
  EXPECT_TRUE(grid.Overlaps(0.2, 0.2, 0.3, kCar));
  EXPECT_FALSE(grid.Overlaps(0.8, 0.2, 0.3, kCar));
  EXPECT_TRUE(grid.Overlaps(0.8, 0.02, 0.3, kCar));  // over the border
}

// First hit among all obstacles, none of them in buckets.
double ReferenceRay(const World& world, double x, double y, double angle, double range) {
  const double c = std::cos(angle), s = std::sin(angle);
  if (SignedDistance(world, Vector3d(x, y, 0)) <= 0) return 0;
  double best = range;
  const auto try_at = [&](double t, const auto& on_edge) {
    if (t >= 0 && t < best && on_edge(Vector3d(x + c * t, y + s * t, 0))) best = t;
  };
  const auto try_box = [&](const Box& box) {
    const auto within_y = [&](const Vector3d& p) { return p.y() >= box.min.y() && p.y() <= box.max.y(); };
    const auto within_x = [&](const Vector3d& p) { return p.x() >= box.min.x() && p.x() <= box.max.x(); };
    for (const double edge : {box.min.x(), box.max.x()}) try_at((edge - x) / c, within_y);
    for (const double edge : {box.min.y(), box.max.y()}) try_at((edge - y) / s, within_x);
  };
  for (const Box& box : world.boxes) try_box(box);
  try_box(world.bounds);
  for (const Cylinder& d : world.cylinders) {
    const double dx = x - d.base.x(), dy = y - d.base.y(), b = dx * c + dy * s;
    const double root = b * b - (dx * dx + dy * dy - d.radius * d.radius);
    if (root >= 0) try_at(-b - std::sqrt(root), [](const Vector3d&) { return true; });
  }
  return best;
}

TEST(ObstacleGridTest, RaysAgreeWithAllObstaclesTried) {
  const World world = TestWorld();
  const ObstacleGrid grid(world, 0.044);
  RandomStream random(3, RandomPurpose::kTest);
  int hits = 0;
  for (int i = 0; i < 5000; ++i) {
    const double x = random.Uniform(world.bounds.min.x(), world.bounds.max.x());
    const double y = random.Uniform(world.bounds.min.y(), world.bounds.max.y());
    const double angle = random.Uniform(-4, 4), range = i % 3 == 0 ? 5.0 : 0.4;
    const double expected = ReferenceRay(world, x, y, angle, range);
    ASSERT_NEAR(grid.CastRay(x, y, std::cos(angle), std::sin(angle), range), expected, 1e-9)
        << x << ", " << y << ", " << angle;
    hits += expected > 0 && expected < range;
  }
  EXPECT_GT(hits, 1500);
}

TEST(ObstacleGridTest, RaysAlongTheAxesWork) {
  World world;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(2, 1, 0)};
  world.boxes = {{Vector3d(1, 0.4, 0), Vector3d(1.2, 0.6, 0)}};
  const ObstacleGrid grid(world, 0.05);
  EXPECT_DOUBLE_EQ(grid.CastRay(0.5, 0.5, 1, 0, 9), 0.5);
  EXPECT_DOUBLE_EQ(grid.CastRay(1.7, 0.5, -1, 0, 9), 0.5);
  EXPECT_DOUBLE_EQ(grid.CastRay(0.5, 0.5, -1, 0, 9), 0.5);
  EXPECT_DOUBLE_EQ(grid.CastRay(0.5, 0.25, 0, 1, 9), 0.75);
  EXPECT_DOUBLE_EQ(grid.CastRay(1.1, 0.75, 0, -1, 9), 0.15);
  EXPECT_DOUBLE_EQ(grid.CastRay(0.5, 0.25, 1, 0, 0.4), 0.4);
  EXPECT_DOUBLE_EQ(grid.CastRay(1.1, 0.5, 0, 1, 9), 0);   // inside an obstacle
  EXPECT_DOUBLE_EQ(grid.CastRay(-0.1, 0.5, 1, 0, 9), 0);  // outside the bounds
}

}  // namespace
}  // namespace cairn
