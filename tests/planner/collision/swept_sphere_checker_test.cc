#include "planner/collision/swept_sphere_checker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

constexpr double kRadius = 0.04;
constexpr double kFclTolerance = 2e-6;  // of FCL's GJK

class SweptSphereCheckerTest : public testing::TestWithParam<int> {};

TEST_P(SweptSphereCheckerTest, PointsAgreeWithTheirDistance) {
  const World world = TwoRooms(GetParam());
  const SweptSphereChecker checker(world, kRadius);
  RandomStream random(1, RandomPurpose::kTest);
  int free = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vector3d p = DrawIn(world, random);
    const double distance = SignedDistance(world, p);
    if (std::abs(distance - kRadius) < kFclTolerance) continue;
    ASSERT_EQ(checker.Free(p), distance > kRadius) << p.transpose();
    free += distance > kRadius;
  }
  EXPECT_GT(free, 1000);
  EXPECT_LT(free, 4700);
}

TEST_P(SweptSphereCheckerTest, MotionsAgreeWithSampledDistances) {
  const World world = TwoRooms(GetParam());
  const SweptSphereChecker checker(world, kRadius);
  RandomStream random(2, RandomPurpose::kTest);
  int free = 0, hit = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d a = DrawIn(world, random), b = a + 0.4 * (DrawIn(world, random) - a);
    const double least = LeastDistance(world, a, b), slack = (b - a).norm() / 200 + kFclTolerance;
    const bool answer = checker.MotionFree(a, b);
    ASSERT_EQ(answer, checker.MotionFree(b, a));
    ASSERT_TRUE(!answer || least > kRadius - kFclTolerance) << a.transpose() << " to " << b.transpose();
    ASSERT_TRUE(answer || least < kRadius + slack) << a.transpose() << " to " << b.transpose();
    (answer ? free : hit) += 1;
  }
  EXPECT_GT(free, 300);
  EXPECT_GT(hit, 300);
}

TEST_P(SweptSphereCheckerTest, BoundsAreObstaclesAndNanIsNotFree) {
  const World world = TwoRooms(GetParam());
  const SweptSphereChecker checker(world, kRadius);
  const double z = GetParam() == 3 ? 0.25 : 0;
  EXPECT_TRUE(checker.Free(Vector3d(kRadius + 1e-6, 0.1, z)));
  EXPECT_FALSE(checker.Free(Vector3d(kRadius - 1e-6, 0.1, z)));
  EXPECT_FALSE(checker.MotionFree(Vector3d(0.1, 0.1, z), Vector3d(0.1, -0.1, z)));
  EXPECT_EQ(checker.Free(Vector3d(0.1, 0.1, 0.01)), GetParam() == 2);  // in the plane z is ignored
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(checker.Free(Vector3d(nan, 0.1, z)));
  EXPECT_FALSE(checker.MotionFree(Vector3d(0.1, 0.1, z), Vector3d(0.1, nan, z)));
}

TEST_P(SweptSphereCheckerTest, ThinWallsAreNotSteppedOver) {
  World world;
  world.dimension = GetParam();
  world.bounds = {Vector3d(0, 0, 0), Vector3d(2, 1, 1)};
  world.boxes = {{Vector3d(1, 0, 0), Vector3d(1 + 1e-6, 1, 1)}};
  const SweptSphereChecker checker(world, 0.01);
  const double z = GetParam() == 3 ? 0.5 : 0;
  EXPECT_FALSE(checker.MotionFree(Vector3d(0.1, 0.3, z), Vector3d(1.9, 0.7, z)));
}

INSTANTIATE_TEST_SUITE_P(Dimensions, SweptSphereCheckerTest, testing::Values(2, 3));

}  // namespace
}  // namespace cairn::planner
