#include "planner/builders/point_tree.h"

#include <gtest/gtest.h>

#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

class PointTreeTest : public testing::TestWithParam<int> {};

TEST_P(PointTreeTest, AgreesWithVisitingAllPoints) {
  const World world = TwoRooms(GetParam());
  PointTree tree(world.dimension);
  std::vector<Vector3d> points;
  std::vector<int32_t> found;
  RandomStream random(1, RandomPurpose::kTest);
  for (int i = 0; i < 1500; ++i) {
    const Vector3d query = DrawIn(world, random);
    int nearest = -1;
    std::vector<int32_t> within;
    for (int k = 0; k < static_cast<int>(points.size()); ++k) {
      const double squared = (points[k] - query).squaredNorm();
      if (nearest < 0 || squared < (points[nearest] - query).squaredNorm()) nearest = k;
      if (squared <= 0.2 * 0.2) within.push_back(k);
    }
    ASSERT_EQ(tree.Nearest(query), nearest);
    const double distance = nearest < 0 ? 1 : (points[nearest] - query).norm();
    ASSERT_FALSE(tree.AnyNearer(query, 0.999 * distance));
    ASSERT_EQ(tree.AnyNearer(query, 1.001 * distance), nearest >= 0 && distance > 0);
    tree.Within(query, 0.2, found);
    ASSERT_EQ(found, within);
    // Some points repeat others or share a coordinate.
    Vector3d p = i % 7 == 6 ? points[i / 2] : DrawIn(world, random);
    if (i % 5 == 4) p.x() = points.back().x();
    points.push_back(p);
    tree.Add(p);
  }
  EXPECT_EQ(tree.size(), 1500);
  tree.Clear();
  EXPECT_EQ(tree.Nearest(Vector3d::Zero()), -1);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, PointTreeTest, testing::Values(2, 3));

}  // namespace
}  // namespace cairn::planner
