#include "common/world/import/moving_ai.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/world/import/map_files.h"

namespace cairn {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kMap = "type octile\nheight 3\nwidth 4\nmap\n.G@O\nS.TW\n@@@.\n";

std::string Error(const std::string& text) {
  return ErrorOf([&] { ReadMovingAi(text, "a.map", 1, 1000000); });
}

TEST(MovingAiTest, ReadsTerrainWithTheFirstRowOnTop) {
  const CellGrid grid = ReadMovingAi(kMap, "a.map", 0.5, 1000000);
  EXPECT_THAT(Rows(grid), ElementsAre("..##", "..##", "###."));
  EXPECT_EQ(grid.origin, Vector3d(0, 0, 0));
  EXPECT_EQ(grid.cell, 0.5);
}

TEST(MovingAiTest, LinesMayEndInCrLfAndTheLastInNothing) {
  EXPECT_THAT(Rows(ReadMovingAi("type octile\r\nheight 1\r\nwidth 2\r\nmap\r\n.@", "a.map", 1, 100)),
              ElementsAre(".#"));
}

TEST(MovingAiErrorTest, NamesLineAndRule) {
  EXPECT_THAT(Error("type tile\n"), HasSubstr("a.map:1: \"type tile\"; a Moving AI map begins with `type octile`"));
  EXPECT_THAT(Error("type octile\nheight x\n"), HasSubstr("a.map:2: \"height x\"; it must be `height N`"));
  EXPECT_THAT(Error("type octile\nheight -3\n"), HasSubstr("a.map:2:"));
  EXPECT_THAT(Error("type octile\nwidth 3\n"), HasSubstr("it must be `height N`"));
  EXPECT_THAT(Error("type octile\nheight 1\nwidth 1\nmaps\n."), HasSubstr("a.map:4:"));
  EXPECT_THAT(Error("type octile\nheight 2\nwidth 2\nmap\n...\n..\n"),
              HasSubstr("a.map:5: \"...\"; a row of 3 cells; width says 2"));
  EXPECT_THAT(Error("type octile\nheight 2\nwidth 2\nmap\n..\n.x\n"), HasSubstr("a.map:6: cell 2 is character 'x'"));
  EXPECT_THAT(Error("type octile\nheight 1000000000\nwidth 1000000000\nmap\n."), HasSubstr("1000000000 cells"));
  EXPECT_THAT(Error("type octile\nheight 900\nwidth 900\nmap\n."), HasSubstr("torn: 900 rows of 900 cells"));
}

TEST(MovingAiErrorTest, TornFilesAreRefusedAtEveryLength) {
  const std::string text = kMap;
  for (size_t length = 0; length + 1 < text.size(); ++length) EXPECT_NE(Error(text.substr(0, length)), "") << length;
}

}  // namespace
}  // namespace cairn
