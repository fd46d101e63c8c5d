#include "common/world/distance_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/core/check.h"
#include "common/core/random.h"

namespace cairn {
namespace {

// Independent of common/world/signed_distance.h: nearest surface point by clamping, depth by faces.
double Reference(const Box& box, const Vector3d& p, int dimension) {
  Vector3d nearest = p;
  double depth = 1e300;
  for (int k = 0; k < dimension; ++k) {
    nearest[k] = std::clamp(p[k], box.min[k], box.max[k]);
    depth = std::min({depth, p[k] - box.min[k], box.max[k] - p[k]});
  }
  return depth > 0 ? -depth : (p - nearest).norm();
}

double Reference(const World& world, const Vector3d& p) {
  double distance = -Reference(world.bounds, p, world.dimension);
  for (const Box& box : world.boxes) distance = std::min(distance, Reference(box, p, world.dimension));
  for (const Cylinder& c : world.cylinders) {
    const double side = (p - c.base).head<2>().norm() - c.radius;
    const double face = std::abs(p.z() - c.base.z() - 0.5 * c.height) - 0.5 * c.height;
    const double solid = side > 0 && face > 0 ? std::hypot(side, face) : std::max(side, face);
    distance = std::min(distance, world.dimension == 2 ? side : solid);
  }
  return distance;
}

World SpaceWorld() {
  World world;
  world.dimension = 3;
  world.bounds = {Vector3d(-1, 0, 2), Vector3d(0, 0.7, 2.5)};
  world.boxes = {{Vector3d(-0.8, 0.1, 2), Vector3d(-0.7, 0.5, 2.3)}, {Vector3d(-0.3, 0, 2.2), Vector3d(0, 0.7, 2.25)}};
  world.cylinders = {{Vector3d(-0.5, 0.3, 2.0), 0.05, 0.2}, {Vector3d(-0.4, 0.6, 2.3), 0.08, 0.1}};
  return world;
}

Vector3d Draw(const World& world, RandomStream& random) {
  Vector3d p = Vector3d::Zero();
  for (int k = 0; k < world.dimension; ++k) p[k] = random.Uniform(world.bounds.min[k], world.bounds.max[k]);
  return p;
}

class DistanceFieldTest : public testing::TestWithParam<int> {
 protected:
  World MakeTestWorld() const {
    if (GetParam() == 3) return SpaceWorld();
    World world = MakeCarMaze(WorldConfig{});
    world.cylinders = {{Vector3d(0.49, 0.41, 0), 0.03, 0}, {Vector3d(1.4, 0.2, 0), 0.01, 0}};
    return world;
  }
};

TEST_P(DistanceFieldTest, IsExactAtNodes) {
  const World world = MakeTestWorld();
  const double h = 0.0125;
  const DistanceField field(world, h);
  const Vector3d extent = world.bounds.size() / h;
  for (int z = 0; z <= (world.dimension == 3 ? std::floor(extent.z() + 1e-9) : 0); ++z) {
    for (int y = 0; y <= std::floor(extent.y() + 1e-9); ++y) {
      for (int x = 0; x <= std::floor(extent.x() + 1e-9); ++x) {
        const Vector3d p = (world.bounds.min + h * Vector3d(x, y, z)).cwiseMin(world.bounds.max);
        ASSERT_NEAR(field.Distance(p), Reference(world, p), 1e-6) << p.transpose();
      }
    }
  }
}

TEST_P(DistanceFieldTest, InterpolationErrorKeepsItsBound) {
  const World world = MakeTestWorld();
  const DistanceField field(world, 0.01);
  EXPECT_NEAR(field.interpolation_error(), 0.005 * std::sqrt(world.dimension), 1e-12);
  RandomStream random(1, RandomPurpose::kTest);
  double worst = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vector3d p = Draw(world, random);
    worst = std::max(worst, std::abs(field.Distance(p) - Reference(world, p)));
  }
  EXPECT_LE(worst, field.interpolation_error() + 1e-6);
  EXPECT_GT(worst, 0.1 * field.interpolation_error());  // the bound is not idle
}

TEST_P(DistanceFieldTest, OutsideTheBoundsIsMinusTheDistanceToThem) {
  const World world = MakeTestWorld();
  const DistanceField field(world, 0.01);
  Vector3d p = world.bounds.max + Vector3d(0.3, 0.4, 0);
  EXPECT_NEAR(field.Distance(p), -0.5, 1e-12);
  EXPECT_FALSE(field.Distance(Vector3d(std::nan(""), p.y(), p.z())) >= -1e300);
}

TEST_P(DistanceFieldTest, CertifiedSegmentsAreTrulyClear) {
  const World world = MakeTestWorld();
  const DistanceField field(world, 0.01);
  RandomStream random(2, RandomPurpose::kTest);
  const double clearance = 0.02, margin = field.interpolation_error() + 0.5 * field.smallest_step();
  int clear = 0, refused = 0;
  for (int i = 0; i < 800; ++i) {
    const Vector3d a = Draw(world, random);
    const Vector3d b = a + 0.3 * (Draw(world, random) - a);
    double least = 1e300;
    for (int k = 0; k <= 60; ++k) least = std::min(least, Reference(world, a + (b - a) * (k / 60.0)));
    if (field.SegmentClear(a, b, clearance + margin)) {
      ++clear;
      ASSERT_GE(least, clearance) << a.transpose() << " to " << b.transpose();
    } else {
      ++refused;
      ASSERT_LT(least, clearance + 2 * margin + (b - a).norm() / 120);
    }
  }
  EXPECT_GT(clear, 20);
  EXPECT_GT(refused, 20);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, DistanceFieldTest, testing::Values(2, 3));

TEST(DistanceFieldLimitTest, RefusesAGridThatIsTooFine) {
  const World world = MakeCarMaze(WorldConfig{});
  try {
    DistanceField field(world, 1e-5);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("world.field_resolution = 1e-05 m"));
    EXPECT_THAT(error.what(), testing::HasSubstr("at least 0.00012 m"));
  }
}

}  // namespace
}  // namespace cairn
