#include "common/world/space_obstacles.h"

#include <gtest/gtest.h>

#include "common/core/random.h"
#include "common/world/cube_maze.h"
#include "common/world/signed_distance.h"

namespace cairn {
namespace {

World MixedWorld() {
  World world;
  world.dimension = 3;
  world.bounds = {Vector3d::Zero(), Vector3d(2, 1.5, 1)};
  RandomStream random(7, RandomPurpose::kTest);
  const auto point = [&] { return Vector3d(random.Uniform(0, 2), random.Uniform(0, 1.5), random.Uniform(0, 1)); };
  for (int i = 0; i < 60; ++i) {
    const Vector3d p = point(), size = 0.1 * point();
    world.boxes.push_back({p, p + size});
  }
  for (int i = 0; i < 30; ++i)
    world.cylinders.push_back({point(), random.Uniform(0.01, 0.08), random.Uniform(0.05, 0.4)});
  return world;
}

Vector3d Draw(const World& world, RandomStream& random) {
  Vector3d p;
  for (int k = 0; k < 3; ++k) p[k] = random.Uniform(world.bounds.min[k] - 0.05, world.bounds.max[k] + 0.05);
  return p;
}

// Signed distance by visiting every obstacle is the truth.
TEST(SpaceObstaclesTest, OverlapsWhereTheDistanceIsBelowTheRadius) {
  WorldConfig cube;
  for (const World& world : {MixedWorld(), MakeCubeMaze(cube)}) {
    const double radius = 0.045;
    const SpaceObstacles obstacles(world, 1.01 * radius);
    RandomStream random(1, RandomPurpose::kTest);
    int touching = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vector3d p = Draw(world, random);
      const double distance = SignedDistance(world, p);
      if (std::abs(distance - radius) < 1e-9) continue;
      ASSERT_EQ(obstacles.Overlaps(p, radius), distance < radius) << p.transpose();
      touching += distance < radius;
    }
    EXPECT_GT(touching, 1000);
    EXPECT_LT(touching, 19000);
  }
}

// Marching along the ray by the true distance (sphere tracing) finds the same first hit.
TEST(SpaceObstaclesTest, RaysEndWhereSphereTracingDoes) {
  WorldConfig cube;
  for (const World& world : {MixedWorld(), MakeCubeMaze(cube)}) {
    const SpaceObstacles obstacles(world, 0.05);
    RandomStream random(2, RandomPurpose::kTest);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vector3d p = Draw(world, random);
      Vector3d direction(random.Normal(), random.Normal(), random.Normal());
      if (i % 4 == 0) direction[static_cast<int>(random.Below(3))] = 0;
      direction.normalize();
      double t = 0;
      for (int step = 0; step < 2000 && t < 0.6; ++step) {
        const double distance = SignedDistance(world, p + t * direction);
        if (distance < 1e-6) break;
        t += distance;
      }
      const double expected = std::min(t, 0.6);
      const double range = obstacles.CastRay(p, direction, 0.6);
      ASSERT_NEAR(range, expected, 2e-4) << i << ": " << p.transpose() << " along " << direction.transpose();
      hits += range < 0.6;
    }
    EXPECT_GT(hits, 500);
  }
}

TEST(SpaceObstaclesTest, LeavingTheBoundsIsATouch) {
  World world;
  world.dimension = 3;
  world.bounds = {Vector3d::Zero(), Vector3d(1, 1, 1)};
  const SpaceObstacles obstacles(world, 0.1);
  EXPECT_FALSE(obstacles.Overlaps({0.5, 0.5, 0.5}, 0.1));
  EXPECT_TRUE(obstacles.Overlaps({0.5, 0.5, 0.95}, 0.1));
  EXPECT_TRUE(obstacles.Overlaps({0.5, 0.5, std::numeric_limits<double>::quiet_NaN()}, 0.1));
  EXPECT_DOUBLE_EQ(obstacles.CastRay({0.5, 0.5, 0.5}, {0, 0, 1}, 2), 0.5);
  EXPECT_EQ(obstacles.CastRay({0.5, 0.5, 1.5}, {0, 0, 1}, 2), 0);
}

}  // namespace
}  // namespace cairn
