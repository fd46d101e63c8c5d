#include "deploy/launcher/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/deploy/launcher/test_support.h"

namespace cairn::deploy {
namespace {

constexpr const char* kCarMaze = CAIRN_SOURCE_DIR "/deploy/experiments/car_maze.textproto";

class PlanTest : public testing::Test {
 protected:
  nlohmann::ordered_json PlanJson(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{CAIRN_PROGRAM, "plan", kCarMaze, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult result = RunProgram(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::ordered_json::parse(result.out);
  }

  TemporaryDirectory directory_;
};

TEST_F(PlanTest, JsonTellsWhatWasBuilt) {
  const auto json = PlanJson();
  EXPECT_GT(json.at("vertices"), 100);
  EXPECT_GE(json.at("edges"), json.at("vertices"));
  EXPECT_GE(json.at("coverage"), 0.999);
  EXPECT_EQ(json.at("components"), 1);
  EXPECT_GT(json.at("max_cost"), json.at("path_length"));
  // From corner to corner of a maze of 1.94 m, between the squares.
  EXPECT_GT(json.at("path_length"), 1.9);
  EXPECT_GT(json.at("build_s"), 0);
}

TEST_F(PlanTest, SameSeedGivesTheSameBytesButForTheTime) {
  auto first = PlanJson({"--svg", directory_ / "a.svg"});
  auto second = PlanJson({"--svg", directory_ / "b.svg"});
  first.erase("build_s");
  second.erase("build_s");
  EXPECT_EQ(first.dump(), second.dump());
  const std::string picture = ReadText(directory_ / "a.svg");
  EXPECT_THAT(picture, testing::StartsWith("<"));
  EXPECT_THAT(picture, testing::HasSubstr("</svg>"));
  EXPECT_EQ(picture, ReadText(directory_ / "b.svg"));
}

TEST_F(PlanTest, OtherSeedsGiveOtherRoadmapsAndMazes) {
  const auto base = PlanJson();
  EXPECT_NE(PlanJson({"--set", "planner.seed=2"}).at("roadmap_hash"), base.at("roadmap_hash"));
  EXPECT_NE(PlanJson({"--set", "world.seed=2"}).at("max_cost"), base.at("max_cost"));
}

TEST_F(PlanTest, TextNamesTheSameFigures) {
  const ProgramResult result = RunProgram({CAIRN_PROGRAM, "plan", kCarMaze});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* word : {"vertices", "edges", "coverage", "components", "longest cost", "build time"}) {
    EXPECT_THAT(result.out, testing::HasSubstr(word));
  }
}

constexpr const char* kNavigate = CAIRN_SOURCE_DIR "/deploy/experiments/navigate.textproto";
constexpr const char* kBurger = CAIRN_SOURCE_DIR "/deploy/robots/turtlebot3_burger.textproto";

// Two rooms of 3 × 3 m and a door of 1 m between them, in the frame of a map_server file.
class PlanMapTest : public PlanTest {
 protected:
  PlanMapTest() {
    std::string image = "P5\n64 34\n255\n";
    for (int y = 0; y < 34; ++y) {
      for (int x = 0; x < 64; ++x) {
        const bool border = x < 2 || y < 2 || x >= 62 || y >= 32, wall = x >= 31 && x < 33 && (y < 12 || y >= 22);
        image += border || wall ? '\0' : '\xfe';
      }
    }
    WriteText(directory_ / "floor.pgm", image);
    WriteText(map_,
              "image: floor.pgm\nresolution: 0.1\norigin: [-1, -2, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
              "free_thresh: 0.196\n");
  }

  ProgramResult PlanMap(std::vector<std::string> more) {
    std::vector<std::string> arguments{CAIRN_PROGRAM, "plan", kNavigate, "--map", map_, "--robot", kBurger};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  const std::string map_ = directory_ / "floor.yaml";
};

TEST_F(PlanMapTest, AMapWithoutAGoalIsDrawnWithItsGrid) {
  const ProgramResult result = PlanMap({"--svg", directory_ / "floor.svg"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("x -0.90 to 5.30, y -1.90 to 1.30 m"));
  EXPECT_THAT(result.out, testing::HasSubstr("--goal X,Y"));
  const std::string picture = ReadText(directory_ / "floor.svg");
  EXPECT_THAT(picture, testing::HasSubstr(">2<"));  // a labelled metre
  EXPECT_THAT(picture, testing::Not(testing::HasSubstr(">goal<")));
  EXPECT_EQ(PlanMap({"--html", directory_ / "floor.html"}).exit_code, 0);
  const std::string page = ReadText(directory_ / "floor.html");
  EXPECT_THAT(page, testing::HasSubstr("no goal yet"));
  EXPECT_THAT(page, testing::Not(testing::HasSubstr("\"goal\":")));
}

TEST_F(PlanMapTest, AGoalInTheOtherRoomIsReachedThroughTheDoor) {
  const ProgramResult result =
      PlanMap({"--goal", "4.8,0.8", "--start", "-0.4,0.8", "--json", "--set", "planner.eta=0.4"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::ordered_json::parse(result.out);
  EXPECT_EQ(json.at("goal_reached_from"), 1);
  EXPECT_EQ(json.at("components"), 1);
  // Straight it would be 5.2 m less two half regions; the door adds little.
  EXPECT_GT(json.at("path_length"), 4.5);
  EXPECT_LT(json.at("path_length"), 6.5);
}

TEST_F(PlanMapTest, GoalsThatCannotBeAreRefusedWithTheNearestPointThatCan) {
  const auto error = [&](const std::string& goal) {
    const ProgramResult result = PlanMap({"--goal", goal});
    EXPECT_EQ(result.exit_code, 2) << goal;
    return result.err;
  };
  // In the wall x = 2.1 … 2.3: free is what keeps 1.2 · 0.074 m from it.
  EXPECT_THAT(error("2.15,-1"), testing::HasSubstr("no point of it is free for a radius of 0.126 m"));
  EXPECT_THAT(error("2.15,-1"), testing::HasSubstr("the nearest point that is: 1.96,-1"));
  EXPECT_THAT(error("77,0"), testing::HasSubstr("world.goal_point: x = 77 m lies outside the world"));
}

TEST_F(PlanTest, PageIsWrittenAlsoOfWorldsInSpaceThatSvgRefuses) {
  const char* const cube = CAIRN_SOURCE_DIR "/deploy/experiments/quadrotor_maze.textproto";
  const ProgramResult result = RunProgram({CAIRN_PROGRAM, "plan", cube, "--html", directory_ / "cube.html"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(ReadText(directory_ / "cube.html"), testing::HasSubstr("\"title\":\"quadrotor_maze\""));
  const ProgramResult refused = RunProgram({CAIRN_PROGRAM, "plan", cube, "--svg", directory_ / "cube.svg"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, testing::HasSubstr("--html"));
}

TEST_F(PlanTest, PictureThatCannotBeWrittenIsAnError) {
  const ProgramResult result = RunProgram({CAIRN_PROGRAM, "plan", kCarMaze, "--svg", directory_ / "no/such.svg"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, testing::HasSubstr("no/such.svg: No such file or directory"));
}

TEST_F(PlanTest, ASavedRoadmapGivesTheSameTable) {
  const std::string file = directory_ / "car.roadmap";
  auto built = PlanJson({"--save", file, "--set", "planner.kind=PRM_STAR"});
  auto read = PlanJson({"--set", "planner.roadmap=\"" + file + "\""});
  EXPECT_EQ(built.at("kind"), "PRM_STAR");
  EXPECT_EQ(read.at("kind"), "PRM_STAR");
  for (const char* key : {"roadmap_hash", "table_hash", "vertices", "edges", "components", "path_length"}) {
    EXPECT_EQ(read.at(key), built.at(key)) << key;
  }
  WriteText(file, ReadText(file).substr(0, 5000));
  const ProgramResult torn = RunProgram({CAIRN_PROGRAM, "plan", kCarMaze, "--set", "planner.roadmap=\"" + file + "\""});
  EXPECT_EQ(torn.exit_code, 2);
  EXPECT_THAT(torn.err, testing::HasSubstr("car.roadmap: torn: 5000 bytes of "));
  EXPECT_EQ(std::count(torn.err.begin(), torn.err.end(), '\n'), 1);
}

class PlanScenarioTest : public PlanTest {
 protected:
  PlanScenarioTest() { WriteText(map_, "type octile\nheight 3\nwidth 4\nmap\n...@\n.@..\n....\n"); }

  // `paths`: lines but for bucket, map and size.
  ProgramResult Check(const std::string& paths, std::vector<std::string> more = {},
                      const std::string& of = "floor.map\t4\t3") {
    std::string text = "version 1\n";
    for (size_t at = 0, end; at < paths.size(); at = end + 1) {
      end = paths.find('\n', at);
      text += "0\t" + of + "\t" + paths.substr(at, end + 1 - at);
    }
    WriteText(directory_ / "floor.map.scen", text);
    std::vector<std::string> arguments{
        CAIRN_PROGRAM, "plan", kNavigate, "--map", map_, "--robot", kBurger, "--scen", directory_ / "floor.map.scen"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  const std::string map_ = directory_ / "floor.map";
};

// Around the cell (1, 1); its corners are not cut. y counts from the top.
TEST_F(PlanScenarioTest, PublishedLengthsThatAgreeEndWithZero) {
  const ProgramResult result = Check("0\t0\t2\t1\t3\n0\t0\t0\t0\t0\n0\t0\t3\t2\t4.41421356\n2\t1\t3\t2\t1.41421356\n");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("floor.map.scen: 4 paths on floor.map, 4 agree, 0 differ"));
}

TEST_F(PlanScenarioTest, EachLengthThatDiffersIsALine) {
  const std::string paths = "0\t0\t2\t1\t2.41421356\n0\t0\t1\t0\t1\n0\t0\t1\t1\t1.41421356\n";
  const ProgramResult result = Check(paths);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out,
              testing::HasSubstr("floor.map.scen:2: (0, 0) to (2, 1): published 2.41421356, shortest 3.00000000\n"));
  EXPECT_THAT(result.out,
              testing::HasSubstr("floor.map.scen:4: (0, 0) to (1, 1): published 1.41421356, but there is no way"));
  EXPECT_THAT(result.out, testing::HasSubstr("3 paths on floor.map, 1 agree, 2 differ"));
  const ProgramResult as_json = Check(paths, {"--json"});
  EXPECT_EQ(as_json.exit_code, 1);
  const auto json = nlohmann::json::parse(as_json.out);
  EXPECT_EQ(json.at("paths"), 3);
  EXPECT_EQ(json.at("agree"), 1);
  ASSERT_EQ(json.at("mismatches").size(), 2u);
  EXPECT_EQ(json.at("mismatches")[0].at("line"), 2);
  EXPECT_EQ(json.at("mismatches")[0].at("shortest"), 3);
  EXPECT_TRUE(json.at("mismatches")[1].at("shortest").is_null());
}

TEST_F(PlanScenarioTest, WhatCannotBeCheckedIsRefused) {
  const auto error = [](const ProgramResult& result) {
    EXPECT_EQ(result.exit_code, 2);
    return result.err;
  };
  const std::string path = "0\t0\t1\t0\t1\n";
  EXPECT_THAT(error(Check(path, {}, "other.map\t4\t3")),
              testing::HasSubstr("it is of other.map, 4 x 3 cells; the map"));
  EXPECT_THAT(error(Check(path, {}, "floor.map\t4\t4")),
              testing::HasSubstr("floor.map, 4 x 4 cells; the map given is"));
  EXPECT_THAT(error(Check("0\t0\t4\t0\t1\n")),
              testing::HasSubstr("floor.map.scen:2: goal x = 4; it must be from 0 to 3"));
  EXPECT_THAT(error(Check("0\t0\n")), testing::HasSubstr("floor.map.scen:2: 6 fields"));
  EXPECT_THAT(error(Check("")), testing::HasSubstr("torn: no path"));
  EXPECT_THAT(error(Check(path, {"--svg", directory_ / "a.svg"})), testing::HasSubstr("--svg does not go with it"));
  const ProgramResult no_map = RunProgram({CAIRN_PROGRAM, "plan", kCarMaze, "--scen", directory_ / "floor.map.scen"});
  EXPECT_THAT(error(no_map), testing::HasSubstr("it goes with a Moving AI map, --map FILE.map"));
  const ProgramResult none =
      RunProgram({CAIRN_PROGRAM, "plan", kNavigate, "--map", map_, "--scen", directory_ / "none.scen"});
  EXPECT_THAT(error(none), testing::HasSubstr("none.scen: No such file or directory"));
}

}  // namespace
}  // namespace cairn::deploy
