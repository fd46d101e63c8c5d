#include "actors/scene.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "common/core/check.h"
#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

bool Same(const Pose& a, const Pose& b) { return a.x == b.x && a.y == b.y && a.yaw == b.yaw; }

TEST(SceneTest, StartsAreFreeInEveryHeadingAndOutsideTheGoal) {
  const Experiment experiment;
  const Scene scene(experiment);
  const Footprint footprint{0.5 * experiment.vehicle.length, 0.5 * experiment.vehicle.width};
  for (int i = 0; i < 200; ++i) {
    const Pose start = i % 2 == 0 ? scene.TrainingStart(i, 0) : scene.EvaluationStart(StartSet::kTest, i);
    const Vector3d p(start.x, start.y, 0);
    EXPECT_GE(scene.field().Distance(p), experiment.vehicle.circumscribed_radius() * (1 + 3.0 / 43.0));
    EXPECT_FALSE(scene.world().Contains(scene.world().goal, p));
    for (int turn = 0; turn < 16; ++turn) {
      EXPECT_FALSE(scene.obstacles().Overlaps(start.x, start.y, turn * 0.4, footprint));
    }
  }
}

TEST(SceneTest, NoRoomIsSaidWithTheClearanceThatWasTested) {
  Experiment experiment = HallExperiment();
  experiment.environment.footprint_scale = 20;
  const double clearance = 20 * experiment.vehicle.circumscribed_radius() * (1 + 3.0 / 43.0);
  try {
    Scene(experiment).TrainingStart(0, 0);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr(fmt::format("no free start {:.4g} m from obstacles", clearance)));
  }
}

TEST(SceneTest, TrainingStartsAreKeyedBySeedVehicleAndEpisode) {
  Experiment experiment;
  const Scene scene(experiment), same(experiment);
  experiment.seed = 2;
  const Scene other(experiment);
  const Pose start = scene.TrainingStart(3, 4);
  EXPECT_TRUE(Same(start, scene.TrainingStart(3, 4)));
  EXPECT_TRUE(Same(start, same.TrainingStart(3, 4)));
  EXPECT_FALSE(Same(start, other.TrainingStart(3, 4)));
  EXPECT_FALSE(Same(start, scene.TrainingStart(4, 3)));
  EXPECT_FALSE(Same(start, scene.TrainingStart(3, 5)));
}

TEST(SceneTest, EvaluationStartsDependOnTheWorldsSeedAlone) {
  Experiment experiment;
  const Scene scene(experiment);
  experiment.seed = 77;
  experiment.environment.start = EnvironmentConfig::Start::kStartRegion;
  experiment.num_vehicles = 5;
  const Scene other_run(experiment);
  experiment.world.seed = 2;
  const Scene other_world(experiment);
  for (int i = 0; i < 20; ++i) {
    const Pose start = scene.EvaluationStart(StartSet::kValidation, i);
    EXPECT_TRUE(Same(start, other_run.EvaluationStart(StartSet::kValidation, i)));
    EXPECT_FALSE(Same(start, other_world.EvaluationStart(StartSet::kValidation, i)));
  }
}

TEST(SceneTest, EvaluationSetsAreDisjoint) {
  const Scene scene{Experiment{}};
  std::set<std::pair<double, double>> seen;
  for (const StartSet set : {StartSet::kConsumption, StartSet::kValidation, StartSet::kTest}) {
    for (int i = 0; i < 200; ++i) {
      const Pose start = scene.EvaluationStart(set, i);
      EXPECT_TRUE(seen.emplace(start.x, start.y).second) << i;
    }
  }
}

TEST(SceneTest, StartRegionHoldsTrainingStarts) {
  Experiment experiment;
  experiment.environment.start = EnvironmentConfig::Start::kStartRegion;
  const Scene scene(experiment);
  for (int i = 0; i < 50; ++i) {
    const Pose start = scene.TrainingStart(0, i);
    EXPECT_TRUE(scene.world().Contains(scene.world().start, Vector3d(start.x, start.y, 0)));
  }
}

// The hall's goal is at its right end: within each fifth of the way to it lies a fifth of the starts, give or take
// three standard deviations.
TEST(SceneTest, StartsByCostToGoAreSpreadEvenlyOverTheWayToTheGoal) {
  Experiment experiment = HallExperiment();
  experiment.environment.start = EnvironmentConfig::Start::kCostToGo;
  const auto scene = MakeScene(experiment), same = MakeScene(experiment);
  const float longest = scene->lookup().table().max_cost();
  constexpr int kStarts = 2000, kShares = 5;
  int shares[kShares] = {};
  for (int i = 0; i < kStarts; ++i) {
    const Pose start = scene->TrainingStart(i % 7, i);
    EXPECT_TRUE(Same(start, same->TrainingStart(i % 7, i)));
    const Vector3d p(start.x, start.y, 0);
    EXPECT_GE(scene->field().Distance(p), experiment.vehicle.circumscribed_radius());
    EXPECT_FALSE(scene->world().Contains(scene->world().goal, p));
    const float cost = scene->lookup().CostToGo(p);
    ASSERT_TRUE(std::isfinite(cost));
    ++shares[std::min(kShares - 1, static_cast<int>(kShares * cost / longest))];
  }
  // The farthest fifth lies in the corners, which the vehicle's radius takes from starts.
  for (int k = 0; k < kShares - 1; ++k) EXPECT_NEAR(shares[k], kStarts / kShares, 54) << k;
}

TEST(SceneTest, StartsByCostToGoFollowTheTableInForce) {
  Experiment experiment = HallExperiment();
  experiment.environment.start = EnvironmentConfig::Start::kCostToGo;
  Scene scene(experiment);
  const Box goal = scene.world().goal;
  scene.SetTable(MakeChain(goal, {1.5f, 2.7f}, 0.5f, 0.05));
  for (int i = 0; i < 20; ++i) EXPECT_NEAR(scene.TrainingStart(0, i).x, 1.5, 0.05 + 1e-6);
  scene.SetTable(MakeChain(goal, {0.5f, 2.7f}, 0.5f, 0.05));
  for (int i = 0; i < 20; ++i) EXPECT_NEAR(scene.TrainingStart(0, i).x, 0.5, 0.05 + 1e-6);
}

// Every quarter of the maze and every quadrant of headings gets its share of 400 starts.
TEST(SceneTest, ShutDoorsMayCutOffAStartRegionThatIsNotUsed) {
  Experiment experiment;
  experiment.world.random_blocked_doors = 3;
  experiment.goals = Goals::kAny;
  int refused = 0;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    experiment.world.seed = seed;
    experiment.environment.start = EnvironmentConfig::Start::kUniform;
    EXPECT_NO_THROW(Scene{experiment}) << seed;
    experiment.environment.start = EnvironmentConfig::Start::kStartRegion;
    try {
      const Scene scene(experiment);
    } catch (const UsageError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0);
}

TEST(SceneTest, AnyGoalIsOnAnyFloorOfTheCube) {
  Experiment experiment;
  experiment.world.kind = WorldConfig::Kind::kCubeMaze;
  experiment.world.floors = 2;
  experiment.world.rooms = 2;
  experiment.world.field_resolution = 0.01;
  experiment.vehicle.kind = VehicleConfig::Kind::kQuadrotor;
  experiment.vehicle.radius = 0.03;
  experiment.goals = Goals::kAny;
  const Scene scene(experiment);
  const double middle = 0.5 * scene.world().bounds.max.z();
  int above = 0;
  for (int i = 0; i < 100; ++i) {
    const Box goal = scene.DrawGoal(StartSet::kTest, i);
    above += 0.5 * (goal.min.z() + goal.max.z()) > middle ? 1 : 0;
  }
  EXPECT_GT(above, 30);
  EXPECT_LT(above, 70);
}

TEST(SceneTest, StartsAreSpreadOverFreeSpace) {
  const Scene scene{Experiment{}};
  int quarter[4] = {}, heading[4] = {};
  const Vector3d center = scene.world().bounds.center();
  for (int i = 0; i < 400; ++i) {
    const Pose start = scene.TrainingStart(i, 1);
    ++quarter[(start.x > center.x()) + 2 * (start.y > center.y())];
    ++heading[static_cast<int>(std::floor(start.yaw / (M_PI / 2))) + 2];
  }
  for (int i = 0; i < 4; ++i) {
    EXPECT_GT(quarter[i], 60);
    EXPECT_GT(heading[i], 60);
  }
}

TEST(SceneTest, TheFirstTableFixesTheScaleOfDMin) {
  const Experiment experiment = HallExperiment();
  Scene scene(experiment);
  const Box goal = scene.world().goal;
  scene.SetTable(MakeChain(goal, {0.5f, 1.5f, 2.7f}, 0.5f, 0.05));
  EXPECT_NEAR(scene.d_min_scale(), 2.2, 1e-6);
  scene.SetTable(MakeChain(goal, {0.1f, 2.7f}, 0.5f, 0.05));
  EXPECT_NEAR(scene.d_min_scale(), 2.2, 1e-6);
  EXPECT_EQ(scene.lookup().num_vertices(), 2);
}

TEST(SceneTest, RefusesAVehicleThatFitsNowhere) {
  Experiment experiment = HallExperiment();
  experiment.vehicle.length = experiment.vehicle.width = 0.9;
  const Scene scene(experiment);
  EXPECT_THROW(scene.TrainingStart(0, 0), UsageError);
}

TEST(SceneTest, EvaluationMeetsWhatTrainingDoesNot) {
  Experiment experiment;
  experiment.world.random_blocked_doors = 3;
  experiment.world.blocked_when = WorldConfig::BlockedWhen::kEvaluation;
  experiment.world.unseen_obstacles = 4;
  const std::shared_ptr<const Scene> training = MakeScene(experiment);
  const std::shared_ptr<const Scene> evaluation = Scene::ForEvaluation(training);
  ASSERT_NE(training, evaluation);
  ASSERT_EQ(evaluation->world().boxes.size(), training->world().boxes.size() + 7);
  for (size_t i = training->world().boxes.size(); i < evaluation->world().boxes.size(); ++i) {
    const Vector3d middle = evaluation->world().boxes[i].center();
    EXPECT_LT(evaluation->field().Distance(middle), 0);
    EXPECT_GT(evaluation->known_field().Distance(middle), evaluation->field().Distance(middle));
    EXPECT_EQ(evaluation->obstacles().CastRay(middle.x(), middle.y(), 1, 0, 1), 0);
  }
  EXPECT_EQ(&evaluation->lookup(), &training->lookup());
  for (int index = 0; index < 100; ++index) {
    const Pose start = evaluation->EvaluationStart(StartSet::kTest, index);
    EXPECT_GT(evaluation->field().Distance({start.x, start.y, 0}), experiment.vehicle.circumscribed_radius());
  }
}

TEST(SceneTest, OneSceneServesBothWhenNothingIsClosedOrAdded) {
  const std::shared_ptr<const Scene> scene = MakeScene(Experiment{});
  EXPECT_EQ(Scene::ForEvaluation(scene), scene);
}

}  // namespace
}  // namespace cairn::actors
