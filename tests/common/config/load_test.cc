#include "common/config/load.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "common/world/distance_field.h"
#include "common/world/reachability.h"
#include "common/world/world.h"

namespace cairn {
namespace {

LoadedExperiment Parse(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return ParseExperiment(text, "test.textproto", overrides);
}

TEST(LoadTest, EmptyFileGivesTheDefaultsOfTheSchema) {
  const Experiment experiment = Parse("").experiment;
  EXPECT_EQ(experiment.schedule, Schedule::kLockstep);
  EXPECT_EQ(experiment.total_env_steps, 250000);
  EXPECT_EQ(experiment.num_vehicles, 32);
  EXPECT_EQ(experiment.learner.net_arch, (std::vector<int>{64, 64}));
  EXPECT_EQ(experiment.learner.target_entropy, -2.0);
  EXPECT_EQ(experiment.transport.group, "239.255.76.67");
}

TEST(LoadTest, LengthsFollowFromTheVehiclesRadii) {
  const Experiment experiment = Parse("vehicle { length: 0.7 width: 0.5 }").experiment;
  const double circumscribed = 0.5 * std::sqrt(0.7 * 0.7 + 0.5 * 0.5), inscribed = 0.25;
  EXPECT_NEAR(experiment.planner.eta, 2.3 * circumscribed, 1e-12);
  EXPECT_NEAR(experiment.planner.radius, 1.2 * inscribed, 1e-12);
  EXPECT_NEAR(experiment.planner.min_spacing, 1.15 * circumscribed, 1e-12);
  EXPECT_NEAR(experiment.vehicle.scan.range, 9.3 * circumscribed, 1e-12);
  EXPECT_NEAR(experiment.observation.look_ahead_near, 2.8 * circumscribed, 1e-12);
  EXPECT_NEAR(experiment.observation.look_ahead_far, 7.0 * circumscribed, 1e-12);
  EXPECT_NEAR(experiment.observation.ray_scale, 1.4 * circumscribed, 1e-12);
  EXPECT_NEAR(experiment.observation.look_ahead_clearance, 0.35 * circumscribed, 1e-12);
  EXPECT_NEAR(experiment.world.field_resolution, 0.005, 1e-15);
}

TEST(LoadTest, LargeWorldsMayTakeMoreSamples) {
  const auto max_samples = [](const std::string& text) { return Parse(text).experiment.planner.max_samples; };
  EXPECT_EQ(max_samples(""), 2000000);
  EXPECT_NEAR(max_samples("world { cells: 10 corridor_width: 0.9 wall_thickness: 0.1 square: 1 } planner { eta: 0.1 }"),
              10201000, 1);
  EXPECT_NEAR(max_samples("world { kind: CUBE_MAZE rooms: 4 floors: 2 room_size: 1 } vehicle { kind: QUADROTOR } "
                          "planner { eta: 0.2 }"),
              4000000, 1);
  EXPECT_NEAR(max_samples("world { kind: BOXES bounds { min { x: -5 } max { x: 5 y: 8 } } start { max { x: 1 y: 1 } } "
                          "goal { max { x: 1 y: 1 } } } planner { eta: 0.1 }"),
              8000000, 1);
}

TEST(LoadTest, TheFieldOfAMazeResolvesItsWallsAndTheRobot) {
  EXPECT_EQ(Parse("").experiment.world.field_resolution, 0.005);
  EXPECT_NEAR(Parse("world { wall_thickness: 0.6 }").experiment.world.field_resolution, 0.025 / 3, 1e-12);
  const std::string quadrotor = "vehicle { kind: QUADROTOR } ";
  EXPECT_NEAR(Parse(quadrotor + "world { kind: CUBE_MAZE }").experiment.world.field_resolution, 0.01, 1e-12);
  EXPECT_NEAR(Parse(quadrotor + "world { kind: CUBE_MAZE wall_thickness: 0.06 }").experiment.world.field_resolution,
              0.045 / 4, 1e-12);
}

// The paper's car in a maze of thick walls.
TEST(LoadTest, AMazeOfThickWallsHasRoom) {
  const Experiment experiment = Parse("world { cells: 4 wall_thickness: 0.6 square: 0.74 }").experiment;
  const World world = MakeWorld(experiment.world);
  const DistanceField field(world, experiment.world.field_resolution);
  EXPECT_NO_THROW(Reachability(world, field, experiment.planner.radius).CheckStart());
}

TEST(LoadTest, ThePapersCarGetsTheMetresOfTheRecipe) {
  const Experiment experiment = Parse("").experiment;
  EXPECT_NEAR(experiment.planner.eta, 0.1, 0.0015);
  EXPECT_NEAR(experiment.planner.radius, 0.03, 1e-12);
  EXPECT_NEAR(experiment.vehicle.scan.range, 0.4, 0.0015);
  EXPECT_NEAR(experiment.observation.look_ahead_near, 0.12, 0.0015);
  EXPECT_NEAR(experiment.observation.look_ahead_far, 0.30, 0.0015);
  EXPECT_NEAR(experiment.observation.ray_scale, 0.06, 0.0015);
  EXPECT_NEAR(experiment.observation.look_ahead_clearance, 0.015, 0.0015);
}

TEST(LoadTest, TheGridsCellsAndNeighborsFollowFromEtaAndTheVehicle) {
  EXPECT_NEAR(Parse("planner { eta: 0.08 }").experiment.planner.grid_cell, 0.02, 1e-12);
  EXPECT_EQ(Parse("planner { grid_cell: 0.03 }").experiment.planner.grid_cell, 0.03);
  EXPECT_EQ(Parse("").experiment.planner.grid_neighbors, 8);
  const Experiment cube = Parse("world { kind: CUBE_MAZE } vehicle { kind: QUADROTOR }").experiment;
  EXPECT_EQ(cube.planner.grid_neighbors, 26);
}

TEST(LoadTest, TypedLengthsAreKept) {
  const Experiment experiment = Parse("planner { eta: 0.08 }").experiment;
  EXPECT_EQ(experiment.planner.eta, 0.08);
  EXPECT_EQ(experiment.planner.min_spacing, 0.04);
}

TEST(LoadTest, BoxWorldTakesItsFieldResolutionFromTheVehicle) {
  const Experiment experiment =
      Parse(
          "world { kind: BOXES bounds { max { x: 2 y: 1 } } start { max { x: .2 y: .2 } } "
          "goal { min { x: 1.8 y: 0.8 } max { x: 2 y: 1 } } obstacles { min { x: 1 } max { x: 1.1 y: 0.5 } } }")
          .experiment;
  EXPECT_DOUBLE_EQ(experiment.world.field_resolution, 0.0025);
  ASSERT_EQ(experiment.world.obstacles.size(), 1u);
  EXPECT_EQ(experiment.world.obstacles[0].max[0], 1.1);
  EXPECT_EQ(experiment.world.goal.min[1], 0.8);
}

TEST(LoadTest, OverridesApplyInOrderAndTheLastWins) {
  const Experiment experiment =
      Parse("learner { batch_size: 128 }", {"learner.batch_size=512", " learner.batch_size = 1024 "}).experiment;
  EXPECT_EQ(experiment.learner.batch_size, 1024);
}

TEST(LoadTest, OverrideReplacesAWholeList) {
  const Experiment experiment = Parse("learner { net_arch: [32, 32, 32] }", {"learner.net_arch=[256,128]"}).experiment;
  EXPECT_EQ(experiment.learner.net_arch, (std::vector<int>{256, 128}));
}

TEST(LoadTest, OverrideReachesNestedFieldsEnumsTextAndBlocks) {
  const Experiment experiment =
      Parse("", {"vehicle.scan.beams=24", "schedule=ASYNC", "name=my_run-2", "learner.algorithm=TD3",
                 "learner.auto_alpha=false", "world={seed: 7 cells: 8}"})
          .experiment;
  EXPECT_EQ(experiment.vehicle.scan.beams, 24);
  EXPECT_EQ(experiment.schedule, Schedule::kAsync);
  EXPECT_EQ(experiment.name, "my_run-2");
  EXPECT_EQ(experiment.learner.algorithm, LearnerConfig::Algorithm::kTd3);
  EXPECT_FALSE(experiment.learner.auto_alpha);
  EXPECT_EQ(experiment.world.seed, 7u);
  EXPECT_EQ(experiment.world.cells, 8);
}

TEST(LoadTest, ResolvedTextIsCanonical) {
  const std::vector<std::string> overrides{"learner.learning_rate=0.0003", "vehicle.width=0.0513",
                                           "learner.net_arch=[64,32]", "name=other"};
  const LoadedExperiment first = Parse("", overrides);
  const LoadedExperiment second = Parse(first.resolved_text);
  EXPECT_EQ(second.resolved_text, first.resolved_text);
  EXPECT_EQ(second.experiment, first.experiment);
  EXPECT_EQ(second.hash, first.hash);
}

TEST(LoadTest, ResolvedTextHoldsEveryOptionButTheRoadmaps) {
  const std::string text = Parse("").resolved_text;
  for (const char* key : {"eta:", "min_spacing:", "target_entropy: -2", "net_arch: [64, 64]",
                          "field_resolution:", "train_freq: 10", "group: \"239.255.76.67\"", "kind: CAR_MAZE"}) {
    EXPECT_NE(text.find(key), std::string::npos) << key;
  }
  EXPECT_EQ(text.find("max_episode_steps"), std::string::npos);
}

TEST(LoadTest, HashIgnoresNameAndTransportOnly) {
  const uint64_t hash = Parse("").hash;
  EXPECT_EQ(Parse("name: \"b\" transport { base_port: 9000 ttl: 1 }").hash, hash);
  EXPECT_EQ(Parse("num_vehicles: 32  # the default").hash, hash);
  EXPECT_NE(Parse("num_vehicles: 31").hash, hash);
  EXPECT_NE(Parse("seed: 2").hash, hash);
}

TEST(LoadTest, EveryShippedExperimentLoads) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(CAIRN_SOURCE_DIR "/deploy/experiments")) {
    if (entry.path().extension() != ".textproto") continue;
    if (entry.path().stem() == "navigate") continue;  // has no map of its own: MapExperimentTest.NavigateTakesAMap
    const LoadedExperiment loaded = LoadExperiment(entry.path());
    EXPECT_EQ(loaded.experiment.name, entry.path().stem()) << entry.path();
    EXPECT_EQ(Parse(loaded.resolved_text).resolved_text, loaded.resolved_text);
    ++count;
  }
  EXPECT_GE(count, 4);
}

TEST(LoadTest, PaperExperimentIsThePapersTable) {
  const Experiment paper = LoadExperiment(CAIRN_SOURCE_DIR "/deploy/experiments/car_maze_paper.textproto").experiment;
  EXPECT_EQ(paper.total_env_steps, 4000000);
  EXPECT_EQ(paper.num_vehicles, 4);
  EXPECT_EQ(paper.learner.learning_rate, 3e-4);
  EXPECT_EQ(paper.learner.batch_size, 1024);
  EXPECT_EQ(paper.learner.n_steps, 1);
  EXPECT_EQ(paper.learner.gradient_steps * 16, 6 * paper.learner.train_freq);
  EXPECT_EQ(ObservationSize(paper), 2 + 2 + 2 + 1);
}

}  // namespace
}  // namespace cairn
