#include "common/world/import/moving_ai_scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/world/import/map_files.h"

namespace cairn {
namespace {

using testing::HasSubstr;

const std::string kScenario =
    "version 1\n"
    "0\tmaps/arena.map\t49\t48\t1\t11\t1\t12\t1.00000000\n"
    "10\tmaps/arena.map\t49\t48\t0\t0\t48\t47\t66.46803743\n";

std::string Error(const std::string& text) {
  return ErrorOf([&] { ReadScenario(text, "a.scen"); });
}

std::string Line(const std::string& fields) { return "version 1\n" + fields + "\n"; }

TEST(ScenarioTest, ReadsPathsWithTheirLines) {
  const Scenario scenario = ReadScenario(kScenario, "a.scen");
  EXPECT_EQ(scenario.map, "maps/arena.map");
  EXPECT_EQ(scenario.width, 49);
  EXPECT_EQ(scenario.height, 48);
  EXPECT_TRUE(scenario.ends_in_line);
  ASSERT_EQ(scenario.paths.size(), 2u);
  EXPECT_EQ(scenario.paths[1].line, 3);
  EXPECT_EQ(scenario.paths[1].start, (std::array<int, 2>{0, 0}));
  EXPECT_EQ(scenario.paths[1].goal, (std::array<int, 2>{48, 47}));
  EXPECT_EQ(scenario.paths[1].length, 66.46803743);
}

TEST(ScenarioTest, LinesMayEndInCrLfTheLastInNothingAndSpacesMayDivide) {
  const Scenario scenario =
      ReadScenario("version 1.0\r\n0 a.map 4 3 0 1 2 2 2.5\r\n\r\n1 a.map 4 3 0 0 0 0 0", "a.scen");
  ASSERT_EQ(scenario.paths.size(), 2u);
  EXPECT_EQ(scenario.paths[0].length, 2.5);
  EXPECT_EQ(scenario.paths[1].line, 4);
  EXPECT_FALSE(scenario.ends_in_line);
  EXPECT_EQ(ReadScenario(Line("0\ta map.map\t4\t3\t0\t1\t2\t2\t2.5"), "a.scen").map, "a map.map");
}

TEST(ScenarioErrorTest, NamesLineAndRule) {
  EXPECT_THAT(Error("type octile\n"), HasSubstr("a.scen:1: a Moving AI scenario begins with `version 1`"));
  EXPECT_THAT(Error(Line("0\ta.map\t4\t3\t0\t1")), HasSubstr("a.scen:2: 6 fields; a scenario's line has 9"));
  EXPECT_THAT(Error(Line("0\ta.map\t4\t3\t4\t1\t2\t2\t1")), HasSubstr("a.scen:2: start x = 4; it must be from 0 to 3"));
  EXPECT_THAT(Error(Line("0\ta.map\t4\t3\t0\t1\t2\t3\t1")), HasSubstr("a.scen:2: goal y = 3; it must be from 0 to 2"));
  EXPECT_THAT(Error(Line("0\ta.map\t4\t3\t0\t-1\t2\t2\t1")), HasSubstr("start y = -1"));
  EXPECT_THAT(Error(Line("0\ta.map\t4\t3\t0\t1\t2\t2\tfar")), HasSubstr("length = \"far\"; it must be a number"));
  EXPECT_THAT(Error(Line("0\ta.map\t4\t3\t0\t1\t2\t2\t-1")), HasSubstr("length = -1; it must be 0 or more"));
  EXPECT_THAT(Error(Line("0\ta.map\t4\t3\t0\t1\t2\t2\tnan")), HasSubstr("length = nan"));
  EXPECT_THAT(Error(Line("0\ta.map\t0\t3\t0\t1\t2\t2\t1")), HasSubstr("width = 0"));
  EXPECT_THAT(Error(Line("0\ta.map\t4\t99999999999\t0\t1\t2\t2\t1")), HasSubstr("height = \"99999999999\""));
  EXPECT_THAT(Error(kScenario + "0\tb.map\t49\t48\t1\t1\t1\t1\t0\n"),
              HasSubstr("a.scen:4: a map of 49 x 48 cells, not"));
}

// Where the last number of a file is torn, what is left may be another number: that shows as another length only.
TEST(ScenarioErrorTest, TornFilesAreRefusedUpToTheirLastNumber) {
  const size_t last_number = kScenario.rfind('\t') + 1, first_line = kScenario.find("1.00000000");
  for (size_t length = 0; length < last_number; ++length) {
    const bool whole_lines = length >= first_line + 1 && length <= first_line + 11;
    if (!whole_lines) {
      EXPECT_NE(Error(kScenario.substr(0, length)), "") << length;
    }
  }
  EXPECT_FALSE(ReadScenario(kScenario.substr(0, kScenario.size() - 3), "a.scen").ends_in_line);
}

}  // namespace
}  // namespace cairn
