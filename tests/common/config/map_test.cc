#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/load.h"
#include "common/core/check.h"
#include "common/world/import/import_map.h"
#include "common/world/world.h"
#include "tests/common/world/import/map_files.h"

// Experiments whose world is a map, and --map, --robot, --goal, --start.
namespace cairn {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A free square of 6 m in a wall of 1 m, with a pillar of 1 m in its middle.
constexpr const char* kRoom =
    "type octile\nheight 9\nwidth 9\nmap\n@@@@@@@@@\n@.......@\n@.......@\n@.......@\n@...@...@\n@.......@\n@.......@\n"
    "@.......@\n@@@@@@@@@\n";

class MapExperimentTest : public testing::Test {
 protected:
  LoadedExperiment Load(const std::string& text, const PlaceArguments& place = {},
                        const std::vector<std::string>& overrides = {}) {
    return LoadExperiment(directory_.Write("e.textproto", text), overrides, place);
  }
  std::string Error(const std::string& text, const PlaceArguments& place = {},
                    const std::vector<std::string>& overrides = {}) {
    return ErrorOf([&] { MakeWorld(Load(text, place, overrides).experiment.world); });
  }

  MapDirectory directory_;
  const std::string map_ = directory_.Write("room.map", kRoom);
};

TEST_F(MapExperimentTest, AMapIsFoundBesideItsFile) {
  const LoadedExperiment loaded = Load("world { kind: MAP map: \"room.map\" goal_point { x: 2 y: 2 } }");
  EXPECT_EQ(loaded.experiment.world.map.file, map_);
  const World world = MakeWorld(loaded.experiment.world);
  EXPECT_TRUE(world.imported);
  EXPECT_EQ(world.bounds.max, Vector3d(9, 9, 0));
  EXPECT_EQ(world.start.min, world.bounds.min);  // everywhere
  // Three circumscribed radii around the point.
  const double side = 3 * loaded.experiment.vehicle.circumscribed_radius();
  EXPECT_TRUE(world.goal.min.isApprox(Vector3d(2 - side, 2 - side, 0)));
  EXPECT_TRUE(world.goal.max.isApprox(Vector3d(2 + side, 2 + side, 0)));
}

// Cells of the map, or whole parts of them with a diagonal of eta / 2.
TEST_F(MapExperimentTest, TheGridHasTheMapsCells) {
  const std::string world = "world { kind: MAP map: \"room.map\" goal_point { x: 2 y: 2 } } ";
  EXPECT_EQ(Load(world + "planner { eta: 2.9 }").experiment.planner.grid_cell, 1);
  EXPECT_EQ(Load(world + "planner { eta: 2.8 }").experiment.planner.grid_cell, 0.5);
  EXPECT_EQ(Load(world + "planner { eta: 0.8 }").experiment.planner.grid_cell, 0.25);
  EXPECT_EQ(Load(world + "planner { eta: 0.4 grid_cell: 1 }").experiment.planner.grid_cell, 1);
}

TEST_F(MapExperimentTest, LargeMapsMayTakeMoreSamples) {
  const std::string world = "world { kind: MAP map: \"room.map\" goal_point { x: 2 y: 2 } } ";  // 9 x 9 m
  EXPECT_EQ(Load(world + "planner { eta: 1 }").experiment.planner.max_samples, 2000000);
  EXPECT_EQ(Load(world + "planner { eta: 0.1 }").experiment.planner.max_samples, 8100000);
  EXPECT_EQ(Load(world + "planner { eta: 0.1 max_samples: 7 }").experiment.planner.max_samples, 7);
}

// The loader knows the file by its bytes alone.
TEST_F(MapExperimentTest, ARoadmapIsFoundBesideItsFileAndKnownByItsBytes) {
  directory_.Write("a.roadmap", "bytes");
  const LoadedExperiment loaded = Load("planner { roadmap: \"a.roadmap\" }");
  EXPECT_EQ(loaded.experiment.planner.roadmap, directory_ / "a.roadmap");
  EXPECT_THAT(loaded.resolved_text, HasSubstr("roadmap: \"roadmap/a.roadmap\""));
  // Elsewhere it is the same experiment, as in a run directory; with other bytes it is another, or refused.
  std::filesystem::create_directory(directory_ / "roadmap");
  directory_.Write("roadmap/a.roadmap", "bytes");
  EXPECT_EQ(Load(loaded.resolved_text).hash, loaded.hash);
  directory_.Write("roadmap/a.roadmap", "other");
  EXPECT_THAT(Error(loaded.resolved_text), AllOf(HasSubstr("planner.roadmap_hash = "), HasSubstr("has changed")));
  directory_.Write("a.roadmap", "other");
  EXPECT_NE(Load("planner { roadmap: \"a.roadmap\" }").hash, loaded.hash);
}

TEST_F(MapExperimentTest, BoundsThatAreInsideOutAreRefused) {
  const std::string bounds = "world { kind: MAP map: \"room.map\" goal_point { x: 2 y: 2 } bounds ";
  EXPECT_NO_THROW(Load(bounds + "{ max { x: 5 y: 5 } } }"));
  EXPECT_THAT(Error(bounds + "{ min { z: 1 } max { x: 5 y: 5 } } }"), HasSubstr("world.bounds is empty"));
  EXPECT_THAT(Error(bounds + "{ min { x: 6 } max { x: 5 y: 5 } } }"), HasSubstr("world.bounds is empty"));
}

TEST_F(MapExperimentTest, ARoadmapIsOfOneWorld) {
  directory_.Write("a.roadmap", "bytes");
  const std::string any = "goals: ANY observation { position: false } planner { kind: RRT roadmap: \"a.roadmap\" } ";
  EXPECT_NO_THROW(Load(any)) << "the kind is not read";
  EXPECT_THAT(Error(any + "world { training_worlds: 2 }"),
              AllOf(HasSubstr("planner.roadmap = "), HasSubstr("is of one world"),
                    HasSubstr("world.training_worlds = 2 and world.unseen_worlds = 0 make 2")));
}

TEST_F(MapExperimentTest, ArgumentsStandInForTheFilesWorld) {
  const LoadedExperiment loaded = Load("world { kind: CAR_MAZE seed: 5 }", {map_, "", "2,3", "7.5,1.5"});
  EXPECT_EQ(loaded.experiment.world.kind, WorldConfig::Kind::kMap);
  EXPECT_EQ(loaded.experiment.world.seed, 5u);
  const World world = MakeWorld(loaded.experiment.world);
  EXPECT_TRUE(world.goal.center().isApprox(Vector3d(2, 3, 0)));
  EXPECT_TRUE(world.start.center().isApprox(Vector3d(7.5, 1.5, 0)));
}

TEST_F(MapExperimentTest, NavigateTakesAMap) {
  const std::string file = CAIRN_SOURCE_DIR "/deploy/experiments/navigate.textproto";
  const LoadedExperiment loaded = LoadExperiment(file, {}, {map_, "", "2,3", ""});
  EXPECT_EQ(loaded.experiment.name, "navigate");
  EXPECT_TRUE(MakeWorld(loaded.experiment.world).imported);
  EXPECT_THAT(ErrorOf([&] { LoadExperiment(file); }), HasSubstr("world.map is missing"));
}

TEST_F(MapExperimentTest, ARegionNeverReachesIntoAnObstacle) {
  const LoadedExperiment loaded = Load("world { point_tolerance: 2 }", {map_, "", "2,4.75", "4.5,2.5"});
  const World world = MakeWorld(loaded.experiment.world);
  EXPECT_EQ(world.goal.min, Vector3d(1, 3.75, 0));  // the wall at x = 1 is a metre away, the pillar at x = 4 two
  EXPECT_EQ(world.goal.max, Vector3d(3, 5.75, 0));
  EXPECT_EQ(world.start.max, Vector3d(6, 4, 0));  // just below the pillar
  const World wide = MakeWorld(Load("world { point_tolerance: 1000 }", {map_, "", "1.95,2", ""}).experiment.world);
  EXPECT_DOUBLE_EQ(wide.goal.min.x(), 1);
  const World inside = MakeWorld(Load("world { point_tolerance: 1000 }", {map_, "", "0.5,2", ""}).experiment.world);
  EXPECT_NEAR(inside.goal.size().x(), 2e-6, 1e-12);
}

TEST_F(MapExperimentTest, TheHashFollowsWhatTheMapSaysAndNotWhereItIs) {
  const PlaceArguments place{map_, "", "2,2", ""};
  const uint64_t hash = Load("", place).hash;
  const std::string copy = directory_.Write("other.map", kRoom);
  EXPECT_EQ(Load("", {copy, "", "2,2", ""}).hash, hash);
  std::string changed = kRoom;
  changed[changed.find("@.......@") + 1] = '@';
  directory_.Write("room.map", changed);
  EXPECT_NE(Load("", place).hash, hash);
}

TEST_F(MapExperimentTest, TheResolvedTextLoadsBesideACopyOfTheMapAndRefusesAChangedOne) {
  const LoadedExperiment first = Load("name: \"floor\"", {map_, "", "2,2", ""});
  std::filesystem::create_directories(directory_ / "run/map");
  CopyMap(map_, directory_ / "run/map");
  const std::string file = directory_.Write("run/experiment.textproto", first.resolved_text);
  const LoadedExperiment second = LoadExperiment(file);
  EXPECT_EQ(second.resolved_text, first.resolved_text);
  EXPECT_EQ(second.hash, first.hash);
  EXPECT_EQ(second.experiment.world.imported->boxes.size(), first.experiment.world.imported->boxes.size());

  std::string changed = kRoom;
  changed[changed.find("@.......@") + 1] = '@';
  directory_.Write("run/map/room.map", changed);
  EXPECT_THAT(ErrorOf([&] { LoadExperiment(file); }),
              AllOf(HasSubstr("experiment.textproto:"), HasSubstr("world.map_hash = \""),
                    HasSubstr("map/room.map has changed")));
}

TEST_F(MapExperimentTest, FieldNodesLieOnTheEdgesOfCells) {
  // A fifth of the inscribed radius, 0.025 / 5 = 0.005 m, would take a two-hundredth of a cell; 81 m² with 2^25 nodes
  // allow 643 parts.
  EXPECT_DOUBLE_EQ(Load("", {map_, "", "2,2", ""}).experiment.world.field_resolution, 1.0 / 200);
  // 0.5 / 5 = 0.1 m: ten parts.
  EXPECT_DOUBLE_EQ(Load("vehicle { length: 1 width: 1 }", {map_, "", "2,2", ""}).experiment.world.field_resolution,
                   0.1);
  // Larger than cells: one.
  EXPECT_DOUBLE_EQ(Load("vehicle { length: 20 width: 20 }", {map_, "", "2,2", ""}).experiment.world.field_resolution,
                   1);
  // 2^25 nodes on 8.1e7 m²: two parts of a cell would be too many.
  EXPECT_DOUBLE_EQ(Load("world { map_resolution: 10 }", {map_, "", "20,20", ""}).experiment.world.field_resolution,
                   10.0 / 643);
}

TEST_F(MapExperimentTest, OtherWorldsAreResolvedAsBefore) {
  const std::string text = Load("").resolved_text;
  for (const char* key : {"unknown_is_free", "point_tolerance", "goal_point", "map"}) {
    EXPECT_EQ(text.find(key), std::string::npos) << key;
  }
}

TEST_F(MapExperimentTest, ARobotFileIsTheVehicle) {
  const std::string robot =
      directory_.Write("robot.textproto", "# mine\nkind: PLANE_CAR\nlength: 0.3\nscan { beams: 24 }\n");
  const Experiment experiment = Load("vehicle { width: 0.4 max_speed: 2 }", {"", robot, "", ""}).experiment;
  EXPECT_EQ(experiment.vehicle.kind, VehicleConfig::Kind::kPlaneCar);
  EXPECT_EQ(experiment.vehicle.length, 0.3);
  EXPECT_EQ(experiment.vehicle.width, 0.05);  // the default: nothing of the file's vehicle stays
  EXPECT_EQ(experiment.vehicle.scan.beams, 24);
  EXPECT_EQ(Load("", {"", robot, "", ""}, {"vehicle.length=0.2"}).experiment.vehicle.length, 0.2);
}

TEST_F(MapExperimentTest, ShippedRobotsLoad) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(CAIRN_SOURCE_DIR "/deploy/robots")) {
    if (entry.path().extension() != ".textproto") continue;
    EXPECT_GT(Load("", {"", entry.path().string(), "", ""}).experiment.vehicle.max_speed, 0) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 1);
}

TEST_F(MapExperimentTest, CylindersStandAmongBoxes) {
  const std::string world =
      "world { kind: BOXES bounds { max { x: 4 y: 4 } } goal_point { x: 3 y: 3 } start_point { x: 1 y: 1 } "
      "cylinders { base { x: 2 y: 2 } radius: 0.5 } ";
  const World made = MakeWorld(Load(world + "}").experiment.world);
  ASSERT_EQ(made.cylinders.size(), 1u);
  EXPECT_EQ(made.cylinders[0].radius, 0.5);
  EXPECT_EQ(made.cylinders[0].base, Vector3d(2, 2, 0));
  EXPECT_THAT(Error(world + "cylinders { base { x: 9 } radius: 1 } }"),
              HasSubstr("world.cylinders[1]: x from 8 to 10 m lies outside"));
  EXPECT_THAT(Error(world + "cylinders { base { x: 1 } } }"), HasSubstr("world.cylinders[1].radius is missing"));
  EXPECT_THAT(Error(world + "cylinders { radius: -1 } }"), HasSubstr("world.cylinders[1].radius = -1"));
}

TEST_F(MapExperimentTest, ErrorsNameTheArgument) {
  EXPECT_THAT(Error("", {map_, "", "2;2", ""}), HasSubstr("--goal 2;2: write it as X,Y or X,Y,Z, in metres"));
  EXPECT_THAT(Error("", {map_, "", "2,nan", ""}), HasSubstr("--goal 2,nan"));
  EXPECT_THAT(Error("", {map_, "", "2", ""}), HasSubstr("--goal 2:"));
  EXPECT_THAT(Error("", {map_, "", "1,2,3,4", ""}), HasSubstr("--goal 1,2,3,4"));
  EXPECT_THAT(Error("", {map_, "", "12,2", ""}),
              HasSubstr("world.goal_point: x = 12 m lies outside the world, 0 to 9 m"));
  EXPECT_THAT(Error("", {map_, "", "", ""}), HasSubstr("world.goal is missing: give it as --goal X,Y"));
  EXPECT_THAT(Error("", {directory_ / "none.map", "", "2,2", ""}), HasSubstr("none.map: No such file"));
  EXPECT_THAT(Error("", {"", directory_ / "none", "", ""}), HasSubstr("--robot " + directory_ / "none"));
  const std::string robot = directory_.Write("robot.textproto", "length: 0.3\nmax_sped: 1\n");
  EXPECT_THAT(
      Error("", {"", robot, "", ""}),
      HasSubstr("robot.textproto:2: vehicle.max_sped: unknown key; the nearest known one is vehicle.max_speed"));
  const std::string slow = directory_.Write("slow.textproto", "length: 0.3\nmax_speed: -1\n");
  EXPECT_THAT(Error("", {"", slow, "", ""}), HasSubstr("slow.textproto:2: vehicle.max_speed = -1"));
}

TEST_F(MapExperimentTest, ErrorsNameTheField) {
  EXPECT_THAT(Error("world { kind: MAP }"), HasSubstr("world.map is missing"));
  EXPECT_THAT(Error("world { map: \"room.map\" }"),
              HasSubstr("e.textproto:1: world.map is read only with world.kind = MAP"));
  EXPECT_THAT(Error("world { unknown_is_free: true }"), HasSubstr("world.unknown_is_free is read only"));
  EXPECT_THAT(Error("world { slice_min: 1 }", {map_, "", "2,2", ""}),
              HasSubstr("e.textproto:1: world.slice_min and world.slice_max"));
  EXPECT_THAT(Error("world { slice_min: 1 slice_max: 2 }", {map_, "", "2,2", ""}), HasSubstr("is a plane map"));
  EXPECT_THAT(Error("world { map_hash: \"12\" }", {map_, "", "2,2", ""}), HasSubstr("world.map_hash = \"12\""));
  EXPECT_THAT(Error("world { obstacles { max { x: 1 y: 1 } } }", {map_, "", "2,2", ""}),
              HasSubstr("world.obstacles[0] is read only with world.kind = BOXES"));
  EXPECT_THAT(Error("world { goal { max { x: 1 y: 1 } } goal_point { x: 1 } }", {map_, "", "", ""}),
              HasSubstr("world.goal_point does not go with world.goal"));
  EXPECT_THAT(Error("", {map_, "", "2,2", ""}, {"world.map_resolution=1e-9"}), HasSubstr("world.map_resolution"));
}

}  // namespace
}  // namespace cairn
