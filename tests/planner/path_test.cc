#include "planner/path.h"

#include <gtest/gtest.h>

namespace cairn::planner {
namespace {

struct Line {
  World world;
  Roadmap roadmap;
  CostTable table;

  // Vertices at x = 0, 1, 2, 3; the goal is at 0, vertex 3 is cut off.
  Line() {
    roadmap.positions = {0, 0, 1, 0, 2, 0, 3, 0};
    table.cost = {0, 1, 2, kUnreachable};
    table.next_vertex = {-1, 0, 1, -1};
    world.start = {Vector3d(0.9, -1, 0), Vector3d(2.5, 1, 0)};
  }
};

TEST(PathTest, FollowsTheTableToTheGoal) {
  const Line line;
  const Path path = PathFrom(line.roadmap, line.table, 2);
  ASSERT_EQ(path.points.size(), 3u);
  EXPECT_EQ(path.points.front(), Vector3d(2, 0, 0));
  EXPECT_EQ(path.points.back(), Vector3d(0, 0, 0));
  EXPECT_EQ(path.length, 2);
  EXPECT_TRUE(PathFrom(line.roadmap, line.table, 3).points.empty());
}

TEST(PathTest, OfATautRoadmapEndsAtTheGoalsBorder) {
  Line line;
  line.table.goal = {Vector3d(-1, -1, 0), Vector3d(0.25, 1, 0)};
  EXPECT_EQ(PathFrom(line.roadmap, line.table, 2).points.back(), Vector3d(0, 0, 0));
  line.roadmap.taut = true;
  EXPECT_EQ(PathFrom(line.roadmap, line.table, 2).points.back(), Vector3d(0.25, 0, 0));
  EXPECT_EQ(PathFrom(line.roadmap, line.table, 0).points.back(), Vector3d(0, 0, 0));
}

TEST(PathTest, StartsAtTheVertexNearestToTheStartsCentre) {
  Line line;
  EXPECT_EQ(OptimalPath(line.world, line.roadmap, line.table).points.front(), Vector3d(2, 0, 0));
  line.world.start = {Vector3d(2.4, -1, 0), Vector3d(2.9, 1, 0)};  // empty: the nearest with finite cost
  EXPECT_EQ(OptimalPath(line.world, line.roadmap, line.table).points.front(), Vector3d(2, 0, 0));
  line.world.start = {Vector3d(-1, -1, 0), Vector3d(1.2, 5, 0)};  // 0 and 1 inside, 1 farther from (0.1, 2)
  EXPECT_EQ(OptimalPath(line.world, line.roadmap, line.table).length, 0);
  line.table.cost.assign(4, kUnreachable);
  EXPECT_TRUE(OptimalPath(line.world, line.roadmap, line.table).points.empty());
}

}  // namespace
}  // namespace cairn::planner
