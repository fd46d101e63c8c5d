#include "common/world/import/import_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/world/import/map_files.h"

namespace cairn {
namespace {

using testing::HasSubstr;

constexpr const char* kYaml =
    "image: {}\nresolution: 0.5\norigin: [1, 2, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

// Free inside a wall of one cell, but for one unknown cell.
std::string Room() {
  return "P2 5 4 255\n"
         "0 0 0 0 0\n0 255 255 255 0\n0 255 255 205 0\n0 0 0 0 0\n";
}

class ImportMapTest : public testing::Test {
 protected:
  std::string WriteRoom(const std::string& image = "room.pgm") {
    directory_.Write("room.pgm", Room());
    return directory_.Write("room.yaml", fmt::format(fmt::runtime(kYaml), image));
  }

  MapDirectory directory_;
};

TEST_F(ImportMapTest, OccupiedAndUnknownCellsBecomeBoxesInTheMapsFrame) {
  const ImportedMap map = ImportMap(WriteRoom());
  EXPECT_EQ(map.dimension, 2);
  EXPECT_EQ(map.cell, 0.5);
  EXPECT_EQ(map.bounds.min, Vector3d(1, 2, 0));
  EXPECT_EQ(map.bounds.max, Vector3d(3.5, 4, 0));
  double area = 0;
  for (const Box& box : map.boxes) area += box.size().x() * box.size().y();
  EXPECT_DOUBLE_EQ(area, 15 * 0.25);
}

TEST_F(ImportMapTest, UnknownCellsAreFreeWhenToldSo) {
  MapOptions options;
  options.unknown_is_free = true;
  double area = 0;
  for (const Box& box : ImportMap(WriteRoom(), options).boxes) area += box.size().x() * box.size().y();
  EXPECT_DOUBLE_EQ(area, 14 * 0.25);
}

TEST_F(ImportMapTest, TheHashIsThatOfWhatTheMapSays) {
  const std::string yaml = WriteRoom();
  const uint64_t hash = ImportMap(yaml).hash;
  EXPECT_EQ(ImportMap(yaml).hash, hash);
  directory_.Write("room.yaml", "# said otherwise\n" + fmt::format(fmt::runtime(kYaml), "./room.pgm"));
  EXPECT_EQ(ImportMap(yaml).hash, hash);
  std::string changed = Room();
  changed[changed.find("255 255 205")] = '0';  // 255 → 055: one more wall
  directory_.Write("room.pgm", changed);
  EXPECT_NE(ImportMap(yaml).hash, hash);
}

TEST_F(ImportMapTest, ACopySaysTheSameWhereverItsImageWas) {
  std::filesystem::create_directories(directory_ / "images");
  std::filesystem::create_directories(directory_ / "copy");
  directory_.Write("images/floor 1.pgm", Room());
  const std::string yaml = directory_.Write("room.yaml", fmt::format(fmt::runtime(kYaml), "images/floor 1.pgm"));
  const std::string copy = CopyMap(yaml, directory_ / "copy");
  EXPECT_EQ(copy, directory_ / "copy/room.yaml");
  const uint64_t hash = ImportMap(yaml).hash;
  std::filesystem::remove_all(directory_ / "images");
  EXPECT_EQ(ImportMap(copy).hash, hash);
}

TEST_F(ImportMapTest, MovingAiCellsHaveOneMetreUnlessToldOtherwise) {
  const std::string path = directory_.Write("a.map", "type octile\nheight 1\nwidth 3\nmap\n..@\n");
  EXPECT_EQ(ImportMap(path).bounds.max, Vector3d(3, 1, 0));
  MapOptions options;
  options.cell_size = 0.2;
  EXPECT_TRUE(ImportMap(path, options).bounds.max.isApprox(Vector3d(0.6, 0.2, 0)));
  EXPECT_TRUE(ImportMap(CopyMap(path, directory_ / ".")).boxes.size() == 1);
}

TEST_F(ImportMapTest, GazeboWorldsAreBoundedByTheirObstaclesOrTheWindow) {
  const std::string cylinder =
      "<model name='{}'><pose>{} 0 0 0 0</pose><link name='l'><collision name='c'><geometry><cylinder><radius>0.5"
      "</radius><length>1</length></cylinder></geometry></collision></link></model>";
  const std::string path =
      directory_.Write("a.world", "<sdf><world>" + fmt::format(fmt::runtime(cylinder), "a", "1 1") +
                                      fmt::format(fmt::runtime(cylinder), "b", "4 3") + "</world></sdf>");
  const ImportedMap map = ImportMap(path);
  EXPECT_EQ(map.bounds.min, Vector3d(0.5, 0.5, 0));
  EXPECT_EQ(map.bounds.max, Vector3d(4.5, 3.5, 0));
  EXPECT_EQ(map.cylinders.size(), 2u);
  EXPECT_EQ(map.cell, 0);
  MapOptions options;
  options.window = Box{Vector3d(0, 0, 0), Vector3d(9, 9, 0)};
  EXPECT_EQ(ImportMap(path, options).bounds.max, Vector3d(9, 9, 0));
  options.slice = Slice{2, 3};
  EXPECT_THAT(ErrorOf([&] { ImportMap(path, options); }), HasSubstr("no model has a cylinder or box within the slice"));
}

TEST_F(ImportMapTest, OptionsThatAFormatDoesNotHaveAreRefused) {
  MapOptions options;
  options.cell_size = 0.1;
  const std::string yaml = WriteRoom();
  EXPECT_THAT(ErrorOf([&] { ImportMap(yaml, options); }), HasSubstr("world.map_resolution = 0.1 m"));
  options = {};
  options.slice = Slice{0, 1};
  EXPECT_THAT(ErrorOf([&] { ImportMap(yaml, options); }), HasSubstr("is a plane map"));
}

TEST_F(ImportMapTest, FilesThatAreNoMapsAreNamed) {
  const auto error = [&](const std::string& path) { return ErrorOf([&] { ImportMap(path); }); };
  EXPECT_THAT(error(directory_ / "none.yaml"), HasSubstr("none.yaml: No such file"));
  EXPECT_THAT(error(WriteRoom("gone.pgm")), HasSubstr("image = gone.pgm; there is no such file"));
  EXPECT_THAT(error(directory_ / "room.pgm"), HasSubstr("give the .yaml file that names this image"));
  EXPECT_THAT(error("a.ot"), HasSubstr("convert_octree"));
  EXPECT_THAT(error("a.txt"), HasSubstr("a map ends in .yaml (map_server), .bt (OctoMap)"));
  std::filesystem::create_directories(directory_ / "d.map");
  EXPECT_THAT(error(directory_ / "d.map"), HasSubstr("d.map: not a file"));
  EXPECT_THAT(error(directory_.Write("large.yaml", std::string(70000, ' '))), HasSubstr("70000 bytes"));
}

}  // namespace
}  // namespace cairn
