#include "planner/builders/builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "common/core/check.h"
#include "common/roadmap/roadmap_lookup.h"
#include "planner/planner.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

using Kind = PlannerConfig::Kind;

constexpr double kInscribed = 0.025;

struct Room {
  World world;
  DistanceField field;
  PlannerConfig config;

  Room(Kind kind, int dimension) : world(TwoRooms(dimension)), field(world, 0.01) {
    config.kind = kind;
    config.path_samples = 3000;
    if (dimension == 3) {
      config.eta = 0.18;
      config.radius = 0.04;
      config.min_spacing = 0.06;
      config.coverage = 0.99;
      config.grid_cell = 0.05;
      config.grid_neighbors = 26;
    }
  }
  BuiltRoadmap Build() const { return BuildRoadmap(world, field, config, kInscribed); }
  CostTable Table(const Roadmap& roadmap) const { return ComputeCostTable(roadmap, world, world.goal); }
};

void ExpectSame(const Roadmap& a, const Roadmap& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.offsets, b.offsets);
  EXPECT_EQ(a.neighbors, b.neighbors);
  EXPECT_EQ(a.lengths, b.lengths);
}

class BuilderTest : public testing::TestWithParam<std::tuple<Kind, int>> {
 protected:
  Room room_{std::get<0>(GetParam()), std::get<1>(GetParam())};
};

TEST_P(BuilderTest, SameSeedGivesTheSameBytesTwiceInOneProcess) {
  const Roadmap first = room_.Build().roadmap;
  ExpectSame(first, room_.Build().roadmap);
  room_.config.seed = 2;
  const bool grid = room_.config.kind == Kind::kGrid;
  EXPECT_EQ(room_.Build().roadmap.Hash() == first.Hash(), grid);  // cells are not drawn
}

TEST_P(BuilderTest, EdgesAreFreeBothWaysAndOfTheirLength) {
  const Roadmap roadmap = room_.Build().roadmap;
  for (int v = 0; v < roadmap.num_vertices(); ++v) {
    for (int e = roadmap.offsets[v]; e < roadmap.offsets[v + 1]; ++e) {
      const int u = roadmap.neighbors[e];
      if (e > roadmap.offsets[v]) {
        ASSERT_LT(roadmap.neighbors[e - 1], u);
      }
      const auto first = roadmap.neighbors.begin() + roadmap.offsets[u];
      ASSERT_TRUE(std::binary_search(first, roadmap.neighbors.begin() + roadmap.offsets[u + 1], v));
      ASSERT_NEAR(roadmap.lengths[e], (roadmap.position(v) - roadmap.position(u)).norm(), 1e-6);
      ASSERT_GE(LeastDistance(room_.world, roadmap.position(v), roadmap.position(u), 40), room_.config.radius - 5e-6);
    }
  }
}

TEST_P(BuilderTest, EveryVertexHasACost) {
  const BuiltRoadmap built = room_.Build();
  for (const float cost : room_.Table(built.roadmap).cost) ASSERT_TRUE(std::isfinite(cost));
  EXPECT_EQ(built.info.components, 1);
}

// DESIGN 22 for every kind: at no point where the robot can be does D(s) come from behind a wall.
TEST_P(BuilderTest, CostsAreNeverReadThroughWalls) {
  const Roadmap roadmap = room_.Build().roadmap;
  RandomStream random(10, RandomPurpose::kTest);
  int pairs = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vector3d p = DrawIn(room_.world, random);
    if (SignedDistance(room_.world, p) < kInscribed) continue;
    for (int v = 0; v < roadmap.num_vertices(); ++v) {
      if ((roadmap.position(v) - p).norm() > room_.config.r_ball()) continue;
      ++pairs;
      ASSERT_GT(LeastDistance(room_.world, p, roadmap.position(v), 40), 0) << p.transpose();
    }
  }
  EXPECT_GT(pairs, 10);
}

TEST_P(BuilderTest, AnEtaThatReadsThroughWallsIsRefused) {
  room_.config.eta = 0.26;  // thinnest wall 0.05, radius at most 0.04, inscribed 0.025: below 0.23
  EXPECT_THROW(room_.Build(), UsageError);
}

std::string NameOf(const testing::TestParamInfo<std::tuple<Kind, int>>& info) {
  constexpr const char* kNames[] = {"Rrg", "PrmStar", "Rrt", "RrtStar", "Grid"};
  return std::string(kNames[static_cast<int>(std::get<0>(info.param))]) + std::to_string(std::get<1>(info.param)) + "d";
}

INSTANTIATE_TEST_SUITE_P(Kinds, BuilderTest,
                         testing::Combine(testing::Values(Kind::kRrg, Kind::kPrmStar, Kind::kRrt, Kind::kRrtStar,
                                                          Kind::kGrid),
                                          testing::Values(2, 3)),
                         NameOf);

class CoveringBuilderTest : public testing::TestWithParam<Kind> {};

TEST_P(CoveringBuilderTest, GivesCostsFromEverywhere) {
  Room room(GetParam(), 2);
  const BuiltRoadmap built = room.Build();
  EXPECT_GE(built.info.coverage, room.config.coverage);
  const RoadmapLookup lookup(2, built.roadmap.positions, room.Table(built.roadmap), room.config.r_ball());
  RandomStream random(9, RandomPurpose::kTest);
  int free = 0, covered = 0;
  while (free < 5000) {
    const Vector3d p = DrawIn(room.world, random);
    if (SignedDistance(room.world, p) < room.config.radius) continue;
    ++free;
    covered += std::isfinite(lookup.CostToGo(p));
  }
  EXPECT_GE(covered / 5000.0, 0.997);
}

// From the start's corner straight through the door to the goal's.
TEST_P(CoveringBuilderTest, CostsAreNearTheShortestWay) {
  Room room(GetParam(), 2);
  const Roadmap roadmap = room.Build().roadmap;
  const RoadmapLookup lookup(2, roadmap.positions, room.Table(roadmap), room.config.r_ball());
  const double straight = std::hypot(1.6, 0.6);
  const float cost = lookup.CostToGo({0.1, 0.1, 0});
  EXPECT_GE(cost, straight - 0.2);
  EXPECT_LE(cost, 1.12 * straight + 0.1);
}

INSTANTIATE_TEST_SUITE_P(Kinds, CoveringBuilderTest, testing::Values(Kind::kRrg, Kind::kPrmStar, Kind::kGrid));

class PathBuilderTest : public testing::TestWithParam<Kind> {};

TEST_P(PathBuilderTest, IsOnePathFromStartToGoalWithItsOwnCosts) {
  Room room(GetParam(), 2);
  const Roadmap roadmap = room.Build().roadmap;
  const int last = roadmap.num_vertices() - 1;
  EXPECT_TRUE(room.world.Contains(room.world.start, roadmap.position(0)));
  EXPECT_TRUE(room.world.Contains(room.world.goal, roadmap.position(last)));
  const CostTable table = room.Table(roadmap);
  for (int v = 0; v < last; ++v) {
    const double step = (roadmap.position(v + 1) - roadmap.position(v)).norm();
    EXPECT_LE(step, room.config.min_spacing + 1e-6);
    if (room.world.Contains(room.world.goal, roadmap.position(v))) continue;
    EXPECT_EQ(table.next_vertex[v], v + 1);
    EXPECT_NEAR(table.cost[v], table.cost[v + 1] + step, 1e-6);
  }
  const RoadmapLookup lookup(2, roadmap.positions, table, room.config.r_ball());
  EXPECT_TRUE(std::isfinite(lookup.CostToGo(roadmap.position(0))));
  EXPECT_FALSE(std::isfinite(lookup.CostToGo({1.9, 0.1, 0})));  // a corner that no sensible path visits
}

TEST_P(PathBuilderTest, ASampleCapWithoutAPathIsRefused) {
  Room room(GetParam(), 2);
  room.config.max_samples = 5;
  try {
    room.Build();
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("planner.max_samples = 5: reached without a path"));
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, PathBuilderTest, testing::Values(Kind::kRrt, Kind::kRrtStar));

TEST(RrtStarTest, MoreSamplesGiveAShorterPathThanRrts) {
  Room rrt(Kind::kRrt, 2), star(Kind::kRrtStar, 2);
  const auto length = [](const Room& room) { return room.Table(room.Build().roadmap).max_cost(); };
  star.config.path_samples = 1;
  const float first = length(star);
  star.config.path_samples = 20000;
  const float best = length(star);
  EXPECT_LT(best, first);
  EXPECT_LT(best, length(rrt));
  EXPECT_LT(best, 1.75);  // from the start's centre it is 1.645 m straight
}

TEST(PrmStarTest, ASampleCapIsRefusedWithTheCoverageReached) {
  Room room(Kind::kPrmStar, 2);
  room.config.max_samples = 100;
  try {
    room.Build();
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("planner.max_samples = 100: reached with coverage 0."));
  }
}

}  // namespace
}  // namespace cairn::planner
