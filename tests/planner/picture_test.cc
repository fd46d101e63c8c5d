#include "planner/picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/core/check.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

using testing::HasSubstr;
using testing::Not;

struct Scene {
  World world = TwoRooms(2);
  Roadmap roadmap;
  CostTable table;
  PictureOptions options;

  Scene() {
    roadmap.positions = {1.8f, 0.8f, 1.2f, 0.5f, 0.2f, 0.2f};
    roadmap.offsets = {0, 1, 3, 4};
    roadmap.neighbors = {1, 0, 2, 1};
    roadmap.lengths = {0.67f, 0.67f, 1.04f, 1.04f};
    table.cost = {0, 0.67f, 1.71f};
    table.next_vertex = {-1, 0, 1};
    options.title = "Two rooms";
    options.width = 400;
  }
};

int Count(const std::string& text, const std::string& word) {
  int count = 0;
  for (size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

TEST(PictureTest, DrawsToScaleWithYUpwards) {
  Scene scene;
  const std::string svg = DrawScene(scene.world, nullptr, nullptr, {}, scene.options);
  // Lower half of the wall: x 1 … 1.05 m, y 0 … 0.4 m, at 200 px/m, margins 62 and 66 px.
  EXPECT_THAT(svg, HasSubstr("<rect x=\"262.00\" y=\"186.00\" width=\"10.00\" height=\"80.00\""));
  EXPECT_THAT(svg, HasSubstr(">x [m]<"));
  EXPECT_THAT(svg, HasSubstr(">start<"));
  EXPECT_THAT(svg, HasSubstr(">goal<"));
  EXPECT_THAT(svg, Not(HasSubstr("cost-to-go")));
}

TEST(PictureTest, RoadmapWithTableShowsPathLengthAndScale) {
  Scene scene;
  const std::string svg = DrawScene(scene.world, &scene.roadmap, &scene.table, {}, scene.options);
  EXPECT_THAT(svg, HasSubstr("cost-to-go [m]"));
  EXPECT_THAT(svg, HasSubstr("optimal path, 1.71 m"));
  EXPECT_THAT(svg, HasSubstr("M102.0 226.0L302.0 166.0L422.0 106.0"));  // the path, drawn twice (casing)
}

TEST(PictureTest, TrajectoriesAreCountedByOutcomeAndCollisionsCrossed) {
  Scene scene;
  const Trajectory good{{Vector3d(0.2, 0.2, 0), Vector3d(0.3, 0.2, 0)}, Outcome::kGoal};
  const Trajectory bad{{Vector3d(0.2, 0.8, 0), Vector3d(0.3, 0.8, 0)}, Outcome::kCollision};
  const Trajectory empty;
  const std::string svg = DrawScene(scene.world, &scene.roadmap, &scene.table, {good, good, bad, empty}, scene.options);
  EXPECT_THAT(svg, HasSubstr(">2 goal<"));
  EXPECT_THAT(svg, HasSubstr(">1 collision<"));
  EXPECT_EQ(Count(svg, "l10 10m0 -10l-10 10"), 2);  // one cross, cased
}

TEST(PictureTest, DoorsAreNumberedInTheirMiddles) {
  Scene scene;
  scene.world.doors = {{Vector3d(1, 0.4, 0), Vector3d(1.05, 0.6, 0)}, {Vector3d(0.2, 0.1, 0), Vector3d(0.4, 0.12, 0)}};
  EXPECT_THAT(DrawScene(scene.world, nullptr, nullptr, {}, scene.options), Not(HasSubstr("id=\"doors\"")));
  scene.options.door_numbers = true;
  const std::string svg = DrawScene(scene.world, nullptr, nullptr, {}, scene.options);
  // 200 px/m, margins 62 and 66 px; the longer side of 0.2 m is 40 px, the letters are 12 px high.
  EXPECT_THAT(svg, HasSubstr("<text x=\"267.0\" y=\"170.3\" font-size=\"12.0\">0</text>"));
  EXPECT_THAT(svg, HasSubstr("<text x=\"122.0\" y=\"248.3\" font-size=\"12.0\">1</text>"));
}

TEST(PictureTest, IsWellFormedAndTextIsEscaped) {
  Scene scene;
  scene.options.title = "a < b & c";
  scene.options.r_ball = 0.1;
  const std::string svg = DrawScene(scene.world, &scene.roadmap, &scene.table, {}, scene.options);
  EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; c"));
  EXPECT_EQ(Count(svg, "<g "), Count(svg, "</g>"));
  EXPECT_EQ(Count(svg, "<text "), Count(svg, "</text>"));
  EXPECT_EQ(Count(svg, "<svg "), 1);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
  EXPECT_THAT(svg, Not(HasSubstr(">-0<")));
  EXPECT_EQ(svg, DrawScene(scene.world, &scene.roadmap, &scene.table, {}, scene.options));
}

TEST(PictureTest, UnreachableVerticesAreGrey) {
  Scene scene;
  scene.table.cost[2] = kUnreachable;
  scene.table.next_vertex[2] = -1;
  const std::string svg = DrawScene(scene.world, &scene.roadmap, &scene.table, {}, scene.options);
  EXPECT_THAT(svg, HasSubstr("#8c959f"));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

// 2 m on 400 px: half pixels of 2.5 mm. A wall of 200 × 80 cells is one rectangle, and a fine grid lies below.
TEST(PictureTest, ImportedMapsAreOnePathOfMergedHalfPixels) {
  Scene scene;
  scene.world.imported = true;
  scene.world.cylinders.clear();
  scene.world.boxes.clear();
  for (int x = 0; x < 200; ++x) {
    for (int y = 0; y < 80; ++y) {
      const Vector3d low(1 + 0.0025 * x, 0.005 * y, 0);
      scene.world.boxes.push_back({low, low + Vector3d(0.0025, 0.005, 0)});
    }
  }
  scene.options.regions = false;
  const std::string svg = DrawScene(scene.world, nullptr, nullptr, {}, scene.options);
  EXPECT_THAT(svg, HasSubstr("<path d=\"M262 186h100v80h-100z\"/>"));
  EXPECT_THAT(svg, HasSubstr("stroke-opacity=\"0.12\""));
  EXPECT_THAT(svg, Not(HasSubstr(">goal<")));
  EXPECT_LT(svg.size(), 12000u);
}

TEST(PictureTest, CorridorsAreDrawnNarrower) {
  World world;
  world.imported = true;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(1, 1000, 0)};
  world.boxes = {{Vector3d(0.5, 400, 0), Vector3d(1, 600, 0)}};
  world.start = world.goal = world.bounds;
  PictureOptions options;
  options.width = 400;
  const std::string svg = DrawScene(world, nullptr, nullptr, {}, options);
  EXPECT_THAT(svg, HasSubstr("height=\"1750\""));  // 1600 px and the margins
}

TEST(PictureTest, AStartThatIsEverywhereIsNotDrawn) {
  Scene scene;
  scene.world.start = scene.world.bounds;
  const std::string svg = DrawScene(scene.world, nullptr, nullptr, {}, scene.options);
  EXPECT_THAT(svg, Not(HasSubstr(">start<")));
  EXPECT_THAT(svg, HasSubstr(">goal<"));
}

TEST(PictureTest, RefusesWorldsInSpaceAndForeignTables) {
  Scene scene;
  EXPECT_THROW(DrawScene(TwoRooms(3), nullptr, nullptr, {}, scene.options), Error);
  scene.table.cost.pop_back();
  EXPECT_THROW(DrawScene(scene.world, &scene.roadmap, &scene.table, {}, scene.options), Error);
}

}  // namespace
}  // namespace cairn::planner
