#include "planner/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "common/core/check.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

struct Scene {
  World world = TwoRooms(3);
  Roadmap roadmap;
  CostTable table;
  PageOptions options;

  Scene() {
    roadmap.dimension = 3;
    roadmap.positions = {1.8f, 0.8f, 0.2f, 1.2f, 0.5f, 0.2f, 0.2f, 0.2f, 0.2f};
    roadmap.offsets = {0, 1, 3, 4};
    roadmap.neighbors = {1, 0, 2, 1};
    roadmap.lengths = {0.67f, 0.67f, 1.04f, 1.04f};
    table.cost = {0, 0.67f, 1.71f};
    table.next_vertex = {-1, 0, 1};
    options.title = "Two rooms";
  }

  std::string Page(const std::vector<Trajectory>& trajectories = {}) const {
    return MakePage(world, &roadmap, &table, trajectories, options);
  }
};

// What stands in the element with the data.
std::string DataText(const std::string& page) {
  const std::string begin = "type=\"application/json\">";
  const size_t at = page.find(begin);
  if (at == std::string::npos) return "";
  return page.substr(at + begin.size(), page.find("</script>", at) - at - begin.size());
}

Json Data(const std::string& page) { return Json::parse(DataText(page)); }

TEST(PageTest, HoldsWorldAndRoadmap) {
  const Json data = Data(Scene().Page());
  EXPECT_EQ(data.at("world").at("boxes"), Json({1, 0, 0, 1.05, 0.4, 0.5, 1, 0.6, 0, 1.05, 1, 0.5}));
  EXPECT_EQ(data.at("world").at("cylinders"), Json({0.5, 0.5, 0, 0.1, 0.3, 1.5, 0.3, 0.2, 0.06, 0.3}));
  EXPECT_EQ(data.at("world").at("goal"), Json({1.7, 0.7, 0, 2, 1, 0.5}));
  EXPECT_EQ(data.at("roadmap").at("vertices"), Json({1.8, 0.8, 0.2, 1.2, 0.5, 0.2, 0.2, 0.2, 0.2}));
  EXPECT_EQ(data.at("roadmap").at("edges"), Json({0, 1, 1, 2}));
  EXPECT_EQ(data.at("roadmap").at("costs"), Json({0, 0.67, 1.71}));
  EXPECT_EQ(data.at("roadmap").at("colors").front(), "#fde725");
  EXPECT_EQ(data.at("path").at("length"), 1.71);
  EXPECT_EQ(data.at("path").at("points").size(), 9);
}

TEST(PageTest, PlaneWorldsGetLowWalls) {
  Scene scene;
  scene.world = TwoRooms(2);
  const Json world = Data(scene.Page()).at("world");
  EXPECT_EQ(world.at("dimension"), 2);
  EXPECT_EQ(world.at("boxes"), Json({1, 0, 0, 1.05, 0.4, 0.07, 1, 0.6, 0, 1.05, 1, 0.07}));
  EXPECT_EQ(world.at("cylinders")[4], 0.07);
  EXPECT_EQ(world.at("bounds"), Json({0, 0, 0, 2, 1, 0.07}));
}

TEST(PageTest, TrajectoriesAreGroupedByOutcome) {
  const Trajectory good{{Vector3d(0.2, 0.2, 0.1), Vector3d(0.3, 0.2, 0.1)}, Outcome::kGoal};
  const Trajectory bad{{Vector3d(0.2, 0.8, 0.1)}, Outcome::kCollision};
  const Json groups = Data(Scene().Page({bad, good, Trajectory(), good})).at("trajectories");
  ASSERT_EQ(groups.size(), 2);
  EXPECT_EQ(groups[0].at("name"), "goal");
  EXPECT_EQ(groups[0].at("paths").size(), 2);
  EXPECT_EQ(groups[0].at("paths")[0], Json({0.2, 0.2, 0.1, 0.3, 0.2, 0.1}));
  EXPECT_EQ(groups[1].at("name"), "collision");
  EXPECT_NE(groups[0].at("color"), groups[1].at("color"));
}

TEST(PageTest, NumbersAreFinite) {
  Scene scene;
  scene.table.cost[2] = kUnreachable;
  scene.table.next_vertex[2] = -1;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Trajectory diverged{{Vector3d(0.2, 0.2, 0.1), Vector3d(nan, 0, 0)}, Outcome::kDiverged};
  const Json data = Data(scene.Page({diverged}));
  EXPECT_EQ(data.at("roadmap").at("costs"), Json({0, 0.67, -1}));
  EXPECT_EQ(data.at("trajectories")[0].at("paths")[0], Json({0.2, 0.2, 0.1}));
  EXPECT_THAT(data.dump(), Not(HasSubstr("null")));  // what the writer would make of them
}

TEST(PageTest, TextCannotLeaveItsElement) {
  Scene scene;
  scene.options.title = "a </script><script>alert(\"x\")</script> & b";
  scene.options.subtitle = "{{three}} \xff";  // a name of the template; no UTF-8
  const std::string page = scene.Page();
  EXPECT_THAT(DataText(page), Not(HasSubstr("<")));
  EXPECT_EQ(Data(page).at("title"), scene.options.title);
  EXPECT_EQ(Data(page).at("subtitle"), "{{three}} \xef\xbf\xbd");
}

TEST(PageTest, StandsAlone) {
  const std::string page = Scene().Page();
  EXPECT_THAT(page, testing::StartsWith("<!DOCTYPE html>"));
  EXPECT_THAT(page, HasSubstr("WebGLRenderer"));
  EXPECT_THAT(page, HasSubstr("OrbitControls"));
  EXPECT_THAT(page, Not(HasSubstr("<script src")));
  EXPECT_THAT(page, Not(HasSubstr("<link")));
  EXPECT_THAT(page, Not(HasSubstr("{{")));
  EXPECT_EQ(page, Scene().Page());
}

TEST(PageTest, DoorsHaveNumbersWhenAskedFor) {
  Scene scene;
  scene.world.doors = {{Vector3d(1, 0.4, 0), Vector3d(1.05, 0.6, 0.5)}};
  EXPECT_FALSE(Data(scene.Page()).at("world").contains("doors"));
  scene.options.door_numbers = true;
  EXPECT_EQ(Data(scene.Page()).at("world").at("doors"), Json({1.025, 0.5, 0.25}));
  scene.world = TwoRooms(2);
  scene.world.doors = {{Vector3d(1, 0.4, 0), Vector3d(1.05, 0.6, 0)}};
  EXPECT_EQ(Data(scene.Page()).at("world").at("doors"), Json({1.025, 0.5, 0.07}));
}

TEST(PageTest, RegionsCanBeLeftOut) {
  Scene scene;
  EXPECT_TRUE(Data(scene.Page()).at("world").contains("start"));
  scene.options.regions = false;
  const Json world = Data(scene.Page()).at("world");
  EXPECT_FALSE(world.contains("start"));
  EXPECT_FALSE(world.contains("goal"));
  EXPECT_EQ(world.at("boxes").size(), 12);
}

TEST(PageTest, WorldsAloneAreEnoughAndForeignTablesRefused) {
  Scene scene;
  const Json data = Data(MakePage(scene.world, nullptr, &scene.table, {}, scene.options));
  EXPECT_FALSE(data.contains("roadmap"));
  EXPECT_FALSE(data.contains("path"));
  EXPECT_FALSE(Data(MakePage(scene.world, &scene.roadmap, nullptr, {}, scene.options)).at("roadmap").contains("costs"));
  scene.table.cost.pop_back();
  EXPECT_THROW(scene.Page(), Error);
}

}  // namespace
}  // namespace cairn::planner
