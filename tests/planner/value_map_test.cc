#include "planner/value_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "planner/picture.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(ValueMapTest, CellsCoverTheBoundsFromTheLowerLeftCorner) {
  World world = TwoRooms(2);
  world.bounds.min.x() = 0.5;  // 1.5 m × 1 m
  const ValueMap map = MakeValueMap(world, 12);
  EXPECT_DOUBLE_EQ(map.cell, 0.125);
  EXPECT_EQ(map.columns, 12);
  EXPECT_EQ(map.rows, 8);
  EXPECT_EQ(map.values.size(), 96u);
  EXPECT_EQ(CellCenter(world, map, 0, 0), Vector3d(0.5625, 0.0625, 0));
  EXPECT_EQ(CellCenter(world, map, 7, 11), Vector3d(1.9375, 0.9375, 0));
}

TEST(ValueMapTest, CostsAreTheCheapestOfEachCellsVertices) {
  const World world = TwoRooms(2);
  Roadmap roadmap;
  roadmap.positions = {0.1f, 0.1f, 0.4f, 0.2f, 1.9f, 0.9f, 2.0f, 1.0f, 0.6f, 0.6f};
  CostTable table;
  table.cost = {3, 2, 7, 8, kUnreachable};
  const ValueMap map = MapCosts(world, roadmap, table, 4);  // cells of 0.5 m
  EXPECT_EQ(map.values[0], 2);
  EXPECT_EQ(map.values[7], 7);  // the edges belong to the last cells
  for (const int i : {1, 2, 3, 4, 5, 6}) EXPECT_TRUE(std::isnan(map.values[i]));
}

TEST(ValueMapTest, PictureHasACellPerRunOfEqualColoursAndTheValuesScale) {
  const World world = TwoRooms(2);
  ValueMap map = MakeValueMap(world, 4);  // 4 × 2 cells of 0.5 m
  map.label = "worth < much";
  map.values[0] = map.values[1] = -5;  // a run below
  map.values[7] = 10;                  // top right
  PictureOptions options;
  options.width = 400;
  options.values = &map;
  const std::string svg = DrawScene(world, nullptr, nullptr, {}, options);
  // 200 px/m, margins 62 and 66 px; dark is low, yellow high.
  EXPECT_THAT(svg, HasSubstr("d=\"M62 266H262V166H62z\""));
  EXPECT_THAT(svg, HasSubstr("d=\"M362 166H462V66H362z\""));
  EXPECT_THAT(svg, HasSubstr("worth &lt; much"));
  EXPECT_THAT(svg, HasSubstr(">-5<"));
  EXPECT_THAT(svg, HasSubstr(">10<"));
  EXPECT_LT(svg.find("M62 266H262"), svg.find("M362 166H462"));  // by colour, low ones first
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(ValueMapTest, NoValuesAndOneValueArePicturesToo) {
  const World world = TwoRooms(2);
  ValueMap map = MakeValueMap(world, 4);
  PictureOptions options;
  options.values = &map;
  EXPECT_THAT(DrawScene(world, nullptr, nullptr, {}, options), Not(testing::AnyOf(HasSubstr("nan"), HasSubstr("inf"))));
  map.values[0] = 3;
  EXPECT_THAT(DrawScene(world, nullptr, nullptr, {}, options), HasSubstr("H252V"));  // one cell of 190 px
}

TEST(ValueMapTest, SliceKeepsWhatStandsAtThatHeight) {
  World world = TwoRooms(3);  // cylinders reach from 0 to 0.3 and from 0.2 to 0.5 m
  world.boxes[1].min.z() = 0.3;
  world.goal.min.z() = 0.25;
  const World low = Slice(world, 0.1), high = Slice(world, 0.4);
  EXPECT_EQ(low.dimension, 2);
  EXPECT_EQ(low.boxes.size(), 1u);
  ASSERT_EQ(low.cylinders.size(), 1u);
  EXPECT_DOUBLE_EQ(low.cylinders[0].radius, 0.1);
  EXPECT_EQ(high.boxes.size(), 2u);
  ASSERT_EQ(high.cylinders.size(), 1u);
  EXPECT_DOUBLE_EQ(high.cylinders[0].radius, 0.06);
  const std::string svg = DrawScene(low, nullptr, nullptr, {}, {});
  EXPECT_THAT(svg, HasSubstr(">start<"));
  EXPECT_THAT(svg, Not(HasSubstr(">goal<")));
  EXPECT_THAT(DrawScene(high, nullptr, nullptr, {}, {}), HasSubstr(">goal<"));
}

}  // namespace
}  // namespace cairn::planner
