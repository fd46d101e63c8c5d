#include "planner/builders/taut_ways.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/world/reachability.h"
#include "planner/builders/bends.h"
#include "planner/cost_to_go.h"
#include "planner/planner.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

constexpr double kRadius = 0.04, kEta = 0.18;

// Two rooms with a lattice of vertices 0.09 m apart and edges to the neighbours along the axes.
struct Scene {
  World world;
  DistanceField field;
  SweptSphereChecker checker;
  Reachability reachability;
  FreeSpace space;
  Roadmap roadmap;

  explicit Scene(int dimension)
      : world(TwoRooms(dimension)),
        field(world, 0.01),
        checker(world, kRadius),
        reachability(world, field, kRadius),
        space(world, checker, reachability) {
    std::vector<Vector3d> points;
    const Eigen::Vector3i cells = ((world.bounds.size() - world.bounds.min) / 0.09).array().ceil().cast<int>();
    for (int i = 0; i < cells.x() * cells.y() * std::max(1, cells.z()); ++i) {
      const Eigen::Vector3i cell(i % cells.x(), i / cells.x() % cells.y(), i / cells.x() / cells.y());
      const Vector3d p = RoundToFloat(0.05 * Vector3d::Ones() + 0.09 * cell.cast<double>(), dimension);
      if (space.Contains(p)) points.push_back(p);
    }
    roadmap.dimension = dimension;
    roadmap.offsets = {0};
    for (const Vector3d& p : points) {
      for (int k = 0; k < dimension; ++k) roadmap.positions.push_back(static_cast<float>(p[k]));
      for (size_t u = 0; u < points.size(); ++u) {
        const double length = (points[u] - p).norm();
        if (length == 0 || length > 0.091 || !checker.MotionFree(p, points[u])) continue;
        roadmap.neighbors.push_back(static_cast<int32_t>(u));
        roadmap.lengths.push_back(static_cast<float>(length));
      }
      roadmap.offsets.push_back(static_cast<int32_t>(roadmap.neighbors.size()));
    }
  }

  Roadmap Taut() const {
    Roadmap taut = roadmap;
    AddTautWays(space, kEta, &taut);
    return taut;
  }
};

bool HasEdge(const Roadmap& roadmap, int from, int to) {
  const auto first = roadmap.neighbors.begin();
  return std::binary_search(first + roadmap.offsets[from], first + roadmap.offsets[from + 1], to);
}

class TautWaysTest : public testing::TestWithParam<int> {
 protected:
  const Scene scene_{GetParam()};
  const Roadmap taut_ = scene_.Taut();
};

TEST_P(TautWaysTest, KeepsVerticesAndEdgesAndAddsFreeOnes) {
  const Roadmap& before = scene_.roadmap;
  ASSERT_EQ(taut_.num_places(), before.num_vertices());
  EXPECT_GT(taut_.num_bends, 10);
  EXPECT_TRUE(taut_.taut);
  EXPECT_TRUE(std::equal(before.positions.begin(), before.positions.end(), taut_.positions.begin()));
  for (int v = 0; v < before.num_vertices(); ++v) {
    for (int e = before.offsets[v]; e < before.offsets[v + 1]; ++e) {
      ASSERT_TRUE(HasEdge(taut_, v, before.neighbors[e]));
    }
  }
  for (int v = 0; v < taut_.num_vertices(); ++v) {
    for (int e = taut_.offsets[v]; e < taut_.offsets[v + 1]; ++e) {
      const Vector3d a = taut_.position(v), b = taut_.position(taut_.neighbors[e]);
      ASSERT_TRUE(HasEdge(taut_, taut_.neighbors[e], v));
      ASSERT_NEAR(taut_.lengths[e], (b - a).norm(), 1e-6);
      ASSERT_LE(taut_.lengths[e], 2 * kEta + 1e-6);
      ASSERT_GE(LeastDistance(scene_.world, a, b, 20), kRadius - 1e-6);
    }
  }
}

// Whatever two vertices see each other within 2 eta: few legs lead from one to the other, hardly longer than the line.
TEST_P(TautWaysTest, StraightWaysHaveNoLongDetour) {
  RandomStream random(3, RandomPurpose::kTest);
  for (int i = 0; i < 40; ++i) {
    const auto v = static_cast<int32_t>(random.Below(static_cast<uint32_t>(taut_.num_vertices())));
    const ShortestPaths paths = ComputeShortestPaths(taut_, std::vector<int32_t>{v});
    for (int u = 0; u < taut_.num_vertices(); ++u) {
      const double length = (taut_.position(u) - taut_.position(v)).norm();
      if (length > 2 * kEta || !scene_.checker.MotionFree(taut_.position(u), taut_.position(v))) continue;
      ASSERT_LE(paths.cost[u], 1.06 * length + 1e-6);
    }
  }
}

TEST_P(TautWaysTest, SameRoadmapSameBytes) {
  const Roadmap again = scene_.Taut();
  EXPECT_EQ(again.positions, taut_.positions);
  EXPECT_EQ(again.neighbors, taut_.neighbors);
  EXPECT_EQ(again.lengths, taut_.lengths);
}

TEST_P(TautWaysTest, BendsAreFreeApartAndBoundedInNumber) {
  const std::vector<Vector3d> bends = FindBends(scene_.space, kEta, 100000);
  for (size_t i = 0; i < bends.size(); ++i) {
    ASSERT_TRUE(scene_.space.Contains(bends[i]));
    for (size_t k = 0; k < i; ++k) ASSERT_GT((bends[k] - bends[i]).norm(), kEta / 5);
  }
  ASSERT_GT(bends.size(), 12u);
  const std::vector<Vector3d> few = FindBends(scene_.space, kEta, 12);
  EXPECT_LE(few.size(), 12u);
  EXPECT_GE(few.size(), 3u);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, TautWaysTest, testing::Values(2, 3));

// Where the tangents of an arc in two parts meet: 22.5° and 67.5° from the wall's faces, 1 / cos(22.5°) radii away.
TEST(BendsTest, StandAroundTheCornersOfABox) {
  World world;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(3, 3, 0)};
  world.boxes = {{Vector3d(1, 1, 0), Vector3d(2, 2, 0)}};
  world.start = world.goal = {Vector3d(0.2, 0.2, 0), Vector3d(0.4, 0.4, 0)};
  const DistanceField field(world, 0.02);
  const SweptSphereChecker checker(world, 0.1);
  const Reachability reachability(world, field, 0.1);
  const FreeSpace space(world, checker, reachability);
  std::vector<Vector3d> bends = FindBends(space, 0.3, 100);
  ASSERT_EQ(bends.size(), 8u);
  const double near = 0.1 * std::tan(std::acos(-1.0) / 8), far = 0.1;
  for (const Vector3d& expected : {Vector3d(2 + far, 2 + near, 0), Vector3d(2 + near, 2 + far, 0),
                                   Vector3d(1 - far, 1 - near, 0), Vector3d(1 - near, 2 + far, 0)}) {
    const auto is_there = [&](const Vector3d& p) { return (p - expected).norm() < 1e-4; };
    EXPECT_EQ(std::count_if(bends.begin(), bends.end(), is_there), 1) << expected.transpose();
  }
  world.boxes.push_back({Vector3d(2, 1, 0), Vector3d(2.5, 2, 0)});  // flush: a joint may keep its bends
  const SweptSphereChecker both(world, 0.1);
  const DistanceField both_field(world, 0.02);
  const Reachability both_reach(world, both_field, 0.1);
  bends = FindBends(FreeSpace(world, both, both_reach), 0.3, 100);
  EXPECT_GE(bends.size(), 8u);
  EXPECT_LE(bends.size(), 12u);
}

}  // namespace
}  // namespace cairn::planner
