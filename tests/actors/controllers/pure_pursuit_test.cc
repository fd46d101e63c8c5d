#include "actors/controllers/pure_pursuit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "actors/evaluation.h"
#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

std::shared_ptr<const Scene> Referee(Experiment experiment) {
  experiment.planner = PurePursuit::Planner(experiment);
  return MakeScene(experiment, experiment.planner.min_spacing);
}

// Speed and yaw rate of a car.
std::pair<double, double> Drive(const PurePursuit& controller, const Pose& pose) {
  const VehicleCommand command = controller.Drive(pose);
  return {command[0], command[1]};
}

// A straight roadmap along y = 0.5 in the hall.
std::shared_ptr<const Scene> StraightLine() {
  auto scene = std::make_shared<Scene>(HallExperiment());
  std::vector<float> xs;
  for (float x = 0.2f; x < 2.98f; x += 0.02f) xs.push_back(x);
  scene->SetTable(MakeChain(scene->world().goal, xs, 0.5f, 0.05));
  return scene;
}

TEST(PurePursuitTest, PlansFartherFromWallsThanTheVehicleReaches) {
  const Experiment experiment;
  const PlannerConfig planner = PurePursuit::Planner(experiment);
  EXPECT_GT(planner.radius, experiment.vehicle.circumscribed_radius());
  EXPECT_LT(planner.radius, 0.5 * experiment.world.corridor_width);
  EXPECT_EQ(planner.eta, experiment.planner.eta);
}

TEST(PurePursuitTest, ItsRoadmapIsNoCoarserThanASmallEtaAllows) {
  Experiment experiment;
  experiment.planner.eta = 0.035;
  EXPECT_EQ(PurePursuit::Planner(experiment).min_spacing, 0.0175);
}

TEST(PurePursuitTest, CruisesAlongAStraightRoadmap) {
  const PurePursuit controller(StraightLine());
  double speed = 0, yaw_rate = 0;
  std::tie(speed, yaw_rate) = Drive(controller, {1.0, 0.5, 0});
  EXPECT_NEAR(speed, 0.7, 1e-3);
  EXPECT_NEAR(yaw_rate, 0, 1e-2);
}

TEST(PurePursuitTest, TurnsInPlaceWhenItFacesElsewhere) {
  const PurePursuit controller(StraightLine());
  double speed = 1, yaw_rate = 0;
  std::tie(speed, yaw_rate) = Drive(controller, {1.0, 0.5, 2.0});
  EXPECT_EQ(speed, 0);
  EXPECT_EQ(yaw_rate, -2);
  std::tie(speed, yaw_rate) = Drive(controller, {1.0, 0.5, -0.6});
  EXPECT_EQ(speed, 0);
  EXPECT_GT(yaw_rate, 1);
}

TEST(PurePursuitTest, SteersBackToTheRoadmap) {
  const PurePursuit controller(StraightLine());
  double speed = 0, yaw_rate = 0;
  std::tie(speed, yaw_rate) = Drive(controller, {1.0, 0.52, 0});
  EXPECT_LT(yaw_rate, 0);
  std::tie(speed, yaw_rate) = Drive(controller, {1.0, 0.48, 0});
  EXPECT_GT(yaw_rate, 0);
}

// 0.115 m from the bumper (x = 2.885) to the wall at x = 3, of 8 R = 0.344 m: a third of top speed.
TEST(PurePursuitTest, SlowsDownBeforeAWall) {
  const PurePursuit controller(StraightLine());
  const double radius = VehicleConfig{}.circumscribed_radius();
  double speed = 0, yaw_rate = 0;
  std::tie(speed, yaw_rate) = Drive(controller, {2.85, 0.5, 0});
  EXPECT_NEAR(speed, 0.115 / (8 * radius), 1e-3);
  std::tie(speed, yaw_rate) = Drive(controller, {2.6, 0.5, 0});
  EXPECT_NEAR(speed, 0.7, 1e-3);
}

// It heads for the pursued point without turning: from below the line up and along, whatever its yaw.
TEST(PurePursuitTest, AHolonomicBaseHeadsStraightForThePoint) {
  Experiment experiment = HallExperiment();
  experiment.vehicle.kind = VehicleConfig::Kind::kHolonomic;
  experiment.vehicle.min_speed = -1;
  auto scene = std::make_shared<Scene>(experiment);
  scene->SetTable(MakeChain(scene->world().goal, {0.2f, 0.6f, 1.0f, 1.4f, 2.7f}, 0.5f, 0.3));
  const PurePursuit controller(scene);
  const VehicleCommand ahead = controller.Drive({1.0, 0.5, 0});
  EXPECT_NEAR(ahead[0], 0.7, 1e-9);
  EXPECT_NEAR(ahead[1], 0, 1e-9);
  const VehicleCommand turned = controller.Drive({1.0, 0.5, M_PI / 2});
  EXPECT_NEAR(turned[0], 0, 1e-9);
  EXPECT_NEAR(turned[1], -0.7, 1e-9);
  EXPECT_EQ(turned[2], 0);
}

TEST(PurePursuitTest, AnAckermannCarSteersAndNeverStops) {
  Experiment experiment = HallExperiment();
  experiment.vehicle.kind = VehicleConfig::Kind::kAckermann;
  auto scene = std::make_shared<Scene>(experiment);
  scene->SetTable(MakeChain(scene->world().goal, {0.2f, 0.6f, 1.0f, 1.4f, 2.7f}, 0.5f, 0.3));
  const PurePursuit controller(scene);
  const VehicleCommand back = controller.Drive({1.0, 0.5, 2.5});
  EXPECT_GT(back[0], 0);
  EXPECT_EQ(back[1], -experiment.vehicle.max_steering);
}

TEST(PurePursuitTest, SolvesTheMazeWithBothCars) {
  for (const auto kind : {VehicleConfig::Kind::kWheeledCar, VehicleConfig::Kind::kPlaneCar}) {
    Experiment experiment;
    experiment.vehicle.kind = kind;
    PurePursuit controller(Referee(experiment));
    const auto summary =
        Summarise(RunEpisodes(MakeScene(experiment), StartSet::kValidation, AllStarts(50), controller));
    EXPECT_GE(summary.successes, 49);
    EXPECT_GT(summary.spl, 0.8);
  }
}

// Scale-free: a world and a car ten times as large, ten times as fast.
TEST(PurePursuitTest, SolvesAMazeOfAnotherScale) {
  Experiment experiment;
  experiment.vehicle.kind = VehicleConfig::Kind::kPlaneCar;
  for (double* length : {&experiment.world.corridor_width, &experiment.world.wall_thickness, &experiment.world.square,
                         &experiment.world.field_resolution, &experiment.vehicle.length, &experiment.vehicle.width,
                         &experiment.vehicle.max_speed, &experiment.vehicle.scan.range, &experiment.planner.eta,
                         &experiment.planner.radius, &experiment.planner.min_spacing}) {
    *length *= 10;
  }
  PurePursuit controller(Referee(experiment));
  const auto summary =
      Summarise(RunEpisodes(MakeScene(experiment, 0.25), StartSet::kValidation, AllStarts(20), controller));
  EXPECT_GE(summary.successes, 19);
}

}  // namespace
}  // namespace cairn::actors
