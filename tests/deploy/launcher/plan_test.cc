#include "deploy/launcher/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST_F(PlanTest, PictureThatCannotBeWrittenIsAnError) {
  const ProgramResult result = RunProgram({CAIRN_PROGRAM, "plan", kCarMaze, "--svg", directory_ / "no/such.svg"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, testing::HasSubstr("no/such.svg: No such file or directory"));
}

}  // namespace
}  // namespace cairn::deploy
