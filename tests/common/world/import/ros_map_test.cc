#include "common/world/import/ros_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/world/import/map_files.h"
#include "tests/common/world/import/png_bytes.h"

namespace cairn {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int64_t kMax = 1000000;
constexpr const char* kYaml =
    "image: map.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1.5, 2, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
    "free_thresh: 0.196\n";

// kYaml with one line in place of the one that begins with its key; an empty value removes it.
std::string YamlWith(const std::string& key, const std::string& value) {
  std::string text = kYaml;
  const size_t begin = text.find(key + ":"), end = text.find('\n', begin) + 1;
  return text.replace(begin, end - begin, value.empty() ? "" : key + ": " + value + "\n");
}

std::string InfoError(const std::string& yaml) {
  return ErrorOf([&] { ParseRosMapInfo(yaml, "m.yaml"); });
}

std::string Pgm(int width, int height, const std::vector<int>& shades) {
  std::string bytes = fmt::format("P5\n# a comment\n{} {}\n255\n", width, height);
  for (const int shade : shades) bytes += static_cast<char>(shade);
  return bytes;
}

std::vector<std::string> PgmRows(const RosMapInfo& info, const std::string& bytes) {
  return Rows(ReadRosMap(info, bytes, "m.pgm", kMax));
}

std::vector<std::string> PngRows(const RosMapInfo& info, const PngImage& image) {
  return Rows(ReadRosMap(info, WritePng(image), "m.png", kMax));
}

TEST(RosMapTest, ReadsItsKeys) {
  const RosMapInfo info = ParseRosMapInfo(kYaml, "m.yaml");
  EXPECT_EQ(info.image, "map.pgm");
  EXPECT_EQ(info.resolution, 0.05);
  EXPECT_EQ(info.origin, Vector3d(-1.5, 2, 0));
  EXPECT_FALSE(info.negate);
  EXPECT_EQ(info.free_thresh, 0.196);
  EXPECT_TRUE(ParseRosMapInfo(YamlWith("negate", "true"), "m.yaml").negate);
  EXPECT_EQ(ParseRosMapInfo(YamlWith("mode", ""), "m.yaml").mode, RosMapInfo::Mode::kTrinary);
  EXPECT_EQ(ParseRosMapInfo(YamlWith("mode", "raw"), "m.yaml").mode, RosMapInfo::Mode::kRaw);
}

TEST(RosMapTest, WhatItPrintsItReadsBack) {
  RosMapInfo info = ParseRosMapInfo(YamlWith("origin", "[0.1, -3.25, 0.7853981633974483]"), "m.yaml");
  info.mode = RosMapInfo::Mode::kScale;
  const RosMapInfo again = ParseRosMapInfo(PrintRosMapInfo(info, "image.png"), "m.yaml");
  EXPECT_EQ(again.image, "image.png");
  EXPECT_EQ(again.mode, info.mode);
  EXPECT_EQ(again.origin, info.origin);
  EXPECT_EQ(again.occupied_thresh, info.occupied_thresh);
}

// map_server: p = (255 − x) / 255; occupied above 0.65, free below 0.196; x = 89 gives 0.651, 90 gives 0.647, 205 gives
// 0.19608, 206 gives 0.192. The image's first row is the map's highest.
TEST(RosMapTest, TrinaryThresholdsAreMapServers) {
  const RosMapInfo info = ParseRosMapInfo(kYaml, "m.yaml");
  EXPECT_THAT(PgmRows(info, Pgm(3, 2, {0, 89, 90, 205, 206, 255})), ElementsAre("##?", "?.."));
  const CellGrid grid = ReadRosMap(info, Pgm(3, 2, {0, 89, 90, 205, 206, 255}), "m.pgm", kMax);
  EXPECT_EQ(grid.origin, Vector3d(-1.5, 2, 0));
  EXPECT_EQ(grid.cell, 0.05);
}

TEST(RosMapTest, NegateReadsShadesTheOtherWayRound) {
  const RosMapInfo info = ParseRosMapInfo(YamlWith("negate", "1"), "m.yaml");
  EXPECT_THAT(PgmRows(info, Pgm(4, 1, {0, 100, 166, 255})), ElementsAre(".?##"));
}

TEST(RosMapTest, RawValuesArePerCent) {
  const RosMapInfo info = ParseRosMapInfo(YamlWith("mode", "raw"), "m.yaml");
  EXPECT_THAT(PgmRows(info, Pgm(7, 1, {0, 19, 20, 65, 66, 100, 101})), ElementsAre("..??##?"));
}

// Grey and alpha. Trinary averages alpha in, over three colours: (3 · 0 + 255) / 4 / 255 = 0.25 bright; scale calls
// what is not opaque unknown.
TEST(RosMapTest, AlphaIsAveragedInByTrinaryAndUnknownInScale) {
  const PngImage image{4, 1, 8, PNG_COLOR_TYPE_GRAY_ALPHA, {0, 255, 255, 255, 255, 254, 0, 0}};
  EXPECT_THAT(PngRows(ParseRosMapInfo(kYaml, "m"), image), ElementsAre("#..#"));
  EXPECT_THAT(PngRows(ParseRosMapInfo(YamlWith("mode", "scale"), "m"), image), ElementsAre("#.??"));
  // 0.25 bright is 0.75 occupied; 0.8 as threshold is not reached any more.
  EXPECT_THAT(PngRows(ParseRosMapInfo(YamlWith("occupied_thresh", "0.8"), "m"), image), ElementsAre("?..#"));
}

TEST(RosMapTest, EveryKindOfPngIsRead) {
  const RosMapInfo info = ParseRosMapInfo(kYaml, "m");
  EXPECT_THAT(PngRows(info, {3, 1, 8, PNG_COLOR_TYPE_GRAY, {0, 128, 255}}), ElementsAre("#?."));
  EXPECT_THAT(PngRows(info, {3, 1, 16, PNG_COLOR_TYPE_GRAY, {0, 0, 128, 0, 255, 255}}), ElementsAre("#?."));
  EXPECT_THAT(PngRows(info, {8, 1, 1, PNG_COLOR_TYPE_GRAY, {0b01100000}}), ElementsAre("#..#####"));
  EXPECT_THAT(PngRows(info, {3, 1, 8, PNG_COLOR_TYPE_PALETTE, {0, 1, 2}}), ElementsAre(".#?"));
  // The mean of red, green and blue: (255 + 255 + 0) / 3 = 170, p = 0.33.
  EXPECT_THAT(PngRows(info, {3, 1, 8, PNG_COLOR_TYPE_RGB, {0, 0, 0, 255, 255, 0, 255, 255, 255}}), ElementsAre("#?."));
  EXPECT_THAT(PngRows(info, {2, 1, 8, PNG_COLOR_TYPE_RGB_ALPHA, {0, 0, 0, 255, 255, 255, 255, 255}}),
              ElementsAre("#."));
}

TEST(RosMapTest, EveryKindOfPgmIsRead) {
  const RosMapInfo info = ParseRosMapInfo(kYaml, "m");
  EXPECT_THAT(PgmRows(info, "P2 # plain\n3 2\n# more\n100\n0 50 100\n100\t100\r\n0"), ElementsAre("#?.", "..#"));
  EXPECT_THAT(PgmRows(info, std::string("P5 2 1 65535\n\xff\xff\0\1", 17)), ElementsAre(".#"));
}

TEST(RosMapTest, YawTurnsTheCellsIntoTheMapsFrame) {
  const RosMapInfo info = ParseRosMapInfo(YamlWith("origin", "[4, 1, 1.5707963267948966]"), "m.yaml");
  const CellGrid grid = ReadRosMap(info, Pgm(3, 1, {0, 255, 255}), "m.pgm", kMax);
  EXPECT_THAT(Rows(grid), ElementsAre(".", ".", "#"));
  EXPECT_TRUE(grid.origin.isApprox(Vector3d(3.95, 1, 0)));
}

TEST(RosMapErrorTest, KeysAreNamedWithLineValueAndRule) {
  for (const char* key : {"image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"}) {
    EXPECT_THAT(InfoError(YamlWith(key, "")),
                AllOf(HasSubstr("m.yaml: "), HasSubstr(std::string(key) + " is missing")));
  }
  EXPECT_THAT(InfoError(YamlWith("resolution", "0")),
              HasSubstr("m.yaml:3: resolution = 0; it must be from 0.0001 to 10"));
  EXPECT_THAT(InfoError(YamlWith("resolution", "-0.05")), HasSubstr("m.yaml:3: resolution = -0.05"));
  EXPECT_THAT(InfoError(YamlWith("resolution", ".nan")), HasSubstr("m.yaml:3: resolution = .nan; it must be a number"));
  EXPECT_THAT(InfoError(YamlWith("resolution", "50")), HasSubstr("metres a pixel, not centimetres"));
  EXPECT_THAT(InfoError(YamlWith("origin", "[1, 2]")), HasSubstr("m.yaml:4: origin; it must be [x, y, yaw]"));
  EXPECT_THAT(InfoError(YamlWith("origin", "[1, b, 0]")), HasSubstr("m.yaml:4: origin = b"));
  EXPECT_THAT(InfoError(YamlWith("negate", "2")), HasSubstr("m.yaml:5: negate = 2; it must be 0 or 1"));
  EXPECT_THAT(InfoError(YamlWith("mode", "ternary")),
              HasSubstr("m.yaml:2: mode = ternary; it must be trinary, scale or raw"));
  EXPECT_THAT(InfoError(YamlWith("occupied_thresh", "65")), HasSubstr("m.yaml:6: occupied_thresh = 65; it must be"));
  EXPECT_THAT(InfoError(YamlWith("occupied_thresh", "0.1")),
              HasSubstr("m.yaml:6: occupied_thresh = 0.1; it must not be less than free_thresh = 0.196"));
  EXPECT_THAT(InfoError("image: [unclosed"), HasSubstr("m.yaml:"));
  EXPECT_THAT(InfoError(""), HasSubstr("m.yaml: a map_server file"));
}

TEST(RosMapErrorTest, TornImagesAreRefusedAtEveryLength) {
  const RosMapInfo info = ParseRosMapInfo(kYaml, "m");
  const std::string pgm = Pgm(7, 5, std::vector<int>(35, 255)), plain = "P2 3 2 255 10 20 30 40 50 60";
  for (const std::string& bytes : {pgm, plain}) {
    const size_t digit = bytes == plain ? 1 : 0;  // without its last digit "60" is a sound "6"
    for (size_t length = 0; length + digit < bytes.size(); ++length) {
      EXPECT_THAT(ErrorOf([&] { PgmRows(info, bytes.substr(0, length)); }), HasSubstr("m.pgm: ")) << length;
    }
  }
  const std::string png = WritePng({7, 5, 8, PNG_COLOR_TYPE_GRAY, std::vector<uint8_t>(35, 255)});
  for (size_t length = 0; length < png.size(); ++length) {
    EXPECT_THAT(ErrorOf([&] { ReadRosMap(info, png.substr(0, length), "m.png", kMax); }),
                HasSubstr("m.png: not a sound PNG image"))
        << length;
  }
}

TEST(RosMapErrorTest, HeadersThatLieAllocateNothing) {
  const RosMapInfo info = ParseRosMapInfo(kYaml, "m");
  const auto error = [&](const std::string& bytes) { return ErrorOf([&] { PgmRows(info, bytes); }); };
  EXPECT_THAT(error("P5 1000000000 1000000000 255\n"),
              AllOf(HasSubstr("torn: 1000000000 x 1000000000"), HasSubstr("there are 0")));
  EXPECT_THAT(error("P5 3000000000 1 255\n"), HasSubstr("width at byte 3 is not a whole number from 0 to 2147483647"));
  EXPECT_THAT(error("P5 -3 1 255\n"), HasSubstr("width at byte 3"));
  EXPECT_THAT(error("P5 1 1 70000\n"), HasSubstr("maxval at byte 7"));
  EXPECT_THAT(error("P5 0 1 255\n"), HasSubstr("none may be 0"));
  EXPECT_THAT(error("P6 1 1 255\n"), HasSubstr("must begin with P5 or P2"));
  EXPECT_THAT(error("P2 1 1 10 11"), HasSubstr("pixel at byte 10 is not a whole number from 0 to 10"));
  // A sound PNG whose header then says 10^9 × 10^9; its checksum is put right.
  std::string png = WritePng({1, 1, 8, PNG_COLOR_TYPE_GRAY, {255}});
  for (const size_t at : {16u, 20u}) png.replace(at, 4, std::string("\x3b\x9a\xca\x00", 4));
  uint32_t crc = ~0u;
  for (size_t i = 12; i < 29; ++i) {
    crc ^= static_cast<uint8_t>(png[i]);
    for (int k = 0; k < 8; ++k) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
  }
  for (int k = 0; k < 4; ++k) png[29 + k] = static_cast<char>(~crc >> (24 - 8 * k));
  EXPECT_THAT(ErrorOf([&] { ReadRosMap(info, png, "m.png", kMax); }), HasSubstr("1000000000 cells"));
}

TEST(RosMapErrorTest, InterlacedAndOtherImagesAreNamed) {
  const RosMapInfo info = ParseRosMapInfo(kYaml, "m");
  const std::string interlaced = WritePng({9, 9, 8, PNG_COLOR_TYPE_GRAY, std::vector<uint8_t>(81, 255), true});
  EXPECT_THAT(ErrorOf([&] { ReadRosMap(info, interlaced, "m.png", kMax); }), HasSubstr("interlaced"));
  EXPECT_THAT(ErrorOf([&] { ReadRosMap(info, "", "m.jpg", kMax); }), HasSubstr("m.jpg: image: only .pgm and .png"));
}

}  // namespace
}  // namespace cairn
