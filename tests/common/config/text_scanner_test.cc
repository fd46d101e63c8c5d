#include "common/config/text_scanner.h"

#include <gtest/gtest.h>

namespace cairn::config {
namespace {

// Path at the place marked with '@' (which is taken out).
std::string PathAtMark(std::string text) {
  const size_t mark = text.find('@');
  text.erase(mark, 1);
  int line = 0, column = 0;
  for (size_t i = 0; i < mark; ++i) {
    column = text[i] == '\n' ? 0 : column + 1;
    line += text[i] == '\n' ? 1 : 0;
  }
  return FieldPathAt(text, line, column);
}

TEST(TextScannerTest, FindsTheFieldOfAValue) {
  EXPECT_EQ(PathAtMark("learner { batch_size: @3 }"), "learner.batch_size");
  EXPECT_EQ(PathAtMark("learner {\n  batch_size: 4\n  gamma: @x\n}"), "learner.gamma");
  EXPECT_EQ(PathAtMark("a: 1 b: @2"), "b");
}

TEST(TextScannerTest, KnowsOpenAndClosedBlocks) {
  EXPECT_EQ(PathAtMark("vehicle { scan { beams: 3 } @"), "vehicle");
  EXPECT_EQ(PathAtMark("vehicle < scan: { beams: @"), "vehicle.scan.beams");
  EXPECT_EQ(PathAtMark("vehicle { } @"), "");
}

TEST(TextScannerTest, SkipsCommentsAndStrings) {
  EXPECT_EQ(PathAtMark("# learner {\nname: \"a { \\\" b: \" seed: @1"), "seed");
  EXPECT_EQ(PathAtMark("name: 'world {' seed: @1"), "seed");
}

TEST(TextScannerTest, StaysInLists) {
  EXPECT_EQ(PathAtMark("learner { net_arch: [1, 2, @x] }"), "learner.net_arch");
  EXPECT_EQ(PathAtMark("learner { net_arch: [1, 2] gamma: @x }"), "learner.gamma");
  EXPECT_EQ(PathAtMark("world { obstacles: [{ min { x: 1 } }, { max { y: @"), "world.obstacles.max.y");
}

TEST(TextScannerTest, SurvivesAnyPlaceInAnyText) {
  const std::string text = "a { b: [1, \"x\\\" ] } > < 'y # z\n\t: , ; } } {";
  for (int line = 0; line < 4; ++line) {
    for (int column = 0; column < 50; ++column) FieldPathAt(text, line, column);
  }
}

}  // namespace
}  // namespace cairn::config
