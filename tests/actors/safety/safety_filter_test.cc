#include "actors/safety/safety_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

Experiment FilteredHall(VehicleConfig::Kind kind = VehicleConfig::Kind::kPlaneCar) {
  Experiment experiment = HallExperiment();
  experiment.vehicle.kind = kind;
  experiment.vehicle.lag = 0.05;
  experiment.safety.filter = SafetyConfig::Filter::kAlways;
  if (experiment.vehicle.holonomic()) experiment.vehicle.min_speed = -1;
  return experiment;
}

// Of a vehicle at a steady speed forwards.
VehicleCommand Apply(const Experiment& experiment, const Motion& motion, const VehicleCommand& command) {
  const auto scene = MakeScene(experiment);
  const auto vehicle = MakeVehicle(experiment.vehicle, experiment.environment);
  RandomStream random(0, RandomPurpose::kTest);
  vehicle->Reset(motion.pose(), random);
  vehicle->Command({motion.vx, 0, 0});
  for (int i = 0; i < 480; ++i) vehicle->Step();
  SafetyFilter filter(*scene);
  RangeFinder ranges(*scene);
  return filter.Apply({command, *vehicle, motion, 0, 0}, ranges);
}

TEST(SafetyFilterTest, LeavesCommandsAloneFarFromEverything) {
  const VehicleCommand command{1, 2, 0};
  EXPECT_EQ(Apply(FilteredHall(), {1.5, 0.5, 0, 0, 1, 0, 0, 0}, command), command);
}

// At 0.6 m/s, 90 mm before a wall: with the caution a command u until the next look takes caution · (v lag + u period)
// until the car stands, and what is free is less by the margin, by what one beam leaves unseen, and by the circle that
// the corners need to turn round.
TEST(SafetyFilterTest, SlowsDownToWhatItCanStopBeforeAWall) {
  const Experiment experiment = FilteredHall();
  const SafetyConfig& safety = experiment.safety;
  const Motion motion{3 - 0.09, 0.5, 0, 0, 0.6, 0, 0, 0};
  const VehicleCommand filtered = Apply(experiment, motion, {1, 0, 0});
  const double free = 0.09 - experiment.vehicle.circumscribed_radius() - 2 * safety.margin - 0.09 * M_PI / 180;
  EXPECT_NEAR(filtered[0], (free / safety.caution - 0.6 * experiment.vehicle.lag) / safety.period, 0.15);
  EXPECT_LT(filtered[0], 0.8);
}

TEST(SafetyFilterTest, BrakesHarderWhatIsTooFastAlready) {
  const Motion slow{2.9, 0.5, 0, 0, 0.1, 0, 0, 0}, fast{2.9, 0.5, 0, 0, 1.0, 0, 0, 0};
  const double allowed = Apply(FilteredHall(), slow, {1, 0, 0})[0];
  EXPECT_GT(allowed, 0.1);
  EXPECT_LT(Apply(FilteredHall(), fast, {1, 0, 0})[0], allowed - 0.1);
}

// Diagonally at a wall that it touches nearly: along the wall it goes on, towards it it stops.
TEST(SafetyFilterTest, SlidesAlongAWall) {
  const Experiment experiment = FilteredHall(VehicleConfig::Kind::kHolonomic);
  const Motion motion{1.5, 1 - 0.025 - 0.003, 0, 0, 0, 0, 0, 0};
  const VehicleCommand filtered = Apply(experiment, motion, {0.5, 0.5, 0});
  EXPECT_NEAR(filtered[0], 0.5, 0.02);
  EXPECT_LT(filtered[1], 0.01);
}

TEST(SafetyFilterTest, BacksAwayFromWhatIsTooNear) {
  const Experiment experiment = FilteredHall(VehicleConfig::Kind::kHolonomic);
  const Motion motion{1.5, 1 - 0.025 - 0.0005, 0, 0, 0, 0, 0, 0};
  EXPECT_LT(Apply(experiment, motion, {0, 0, 0})[1], -1e-3);
}

// Beside a wall 28.5 mm to the left: straight on is free; turning left swings the front corner, half a length ahead,
// into what the margin and one beam in a straight line leave of the gap.
TEST(SafetyFilterTest, DoesNotTurnACornerIntoAWall) {
  const Experiment experiment = FilteredHall();
  const SafetyConfig& safety = experiment.safety;
  const Motion motion{1.5, 1 - 0.0285, 0, 0, 0, 0, 0, 0};
  const double free = 0.0285 - 0.5 * experiment.vehicle.width - safety.margin - 0.5 * 0.0285 * M_PI / 90;
  const VehicleCommand left = Apply(experiment, motion, {0, 2, 0});
  EXPECT_LT(left[1] * safety.period * safety.caution * 0.5 * experiment.vehicle.length, free);
  EXPECT_LT(left[1], 1.2);
  EXPECT_NEAR(Apply(experiment, motion, {0.2, 0, 0})[0], 0.2, 1e-3);
}

// Whatever is asked for: nothing is touched in a minute of random commands, each held for 0.1 s, in a narrow box.
class RandomCommandsTest : public ::testing::TestWithParam<VehicleConfig::Kind> {};

TEST_P(RandomCommandsTest, TouchNothing) {
  Experiment experiment = FilteredHall(GetParam());
  const bool flies = GetParam() == VehicleConfig::Kind::kQuadrotor;
  experiment.world.bounds = {{0, 0, 0}, {0.5, 0.3, flies ? 0.3 : 0}};
  experiment.world.start = {{0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}};
  experiment.world.goal = {{0.45, 0.1, 0}, {0.5, 0.2, 0.3}};
  experiment.world.obstacles = {{{0.28, 0, 0}, {0.3, 0.12, 1}}, {{0.28, 0.26, 0}, {0.3, 0.3, 1}}};
  experiment.environment.max_episode_steps = 100;
  if (flies) {
    experiment.vehicle.radius = 0.045;
    experiment.vehicle.min_speed = -1.5;
    experiment.vehicle.max_speed = 1.5;
    experiment.safety.beams = 256;
    experiment.vehicle.scan.beams = 14;
  }
  const auto count = [&] {
    const auto scene = MakeScene(experiment);
    Environment environment(scene);
    int collisions = 0, filtered = 0;
    for (int episode = 0; episode < 6; ++episode) {
      environment.ResetTraining(0, episode);
      RandomStream random(1, RandomPurpose::kTest, static_cast<uint32_t>(episode));
      SegmentEnd end = SegmentEnd::kNone;
      while (end == SegmentEnd::kNone) {
        float action[3];
        for (float& a : action) a = static_cast<float>(random.Uniform(-1, 1));
        end = environment.Step(action).end;
      }
      collisions += environment.episode().outcome == Outcome::kCollision;
      filtered += environment.episode().filtered_steps;
    }
    return std::pair(collisions, filtered);
  };
  const auto [collisions, filtered] = count();
  EXPECT_EQ(collisions, 0);
  EXPECT_GT(filtered, 50);
  experiment.safety.filter = SafetyConfig::Filter::kOff;
  const auto [collisions_without, filtered_without] = count();
  EXPECT_GE(collisions_without, 4);
  EXPECT_EQ(filtered_without, 0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, RandomCommandsTest,
                         ::testing::Values(VehicleConfig::Kind::kWheeledCar, VehicleConfig::Kind::kPlaneCar,
                                           VehicleConfig::Kind::kHolonomic, VehicleConfig::Kind::kAckermann,
                                           VehicleConfig::Kind::kQuadrotor));

// Into a wall, round, and away again: a car that cannot reverse stops where it can still turn.
TEST(SafetyFilterTest, KeepsRoomToTurnRound) {
  const auto scene = MakeScene(FilteredHall());
  Environment environment(scene);
  environment.ResetEvaluation(
      StartSet::kTest,
      FindEvaluationStart(
          *scene,
          [](const Pose& p) { return std::abs(p.yaw) > 3 && p.x > 0.3 && p.x < 0.6 && p.y > 0.3 && p.y < 0.7; }),
      0);
  const Action ahead(1, 0), turn(0, 2);
  for (int i = 0; i < 30; ++i) ASSERT_EQ(environment.Step(ahead.data()).end, SegmentEnd::kNone);
  EXPECT_LT(environment.pose().x, 0.055);
  for (int i = 0; i < 16; ++i) ASSERT_EQ(environment.Step(turn.data()).end, SegmentEnd::kNone);
  EXPECT_LT(std::abs(std::remainder(environment.pose().yaw, 2 * M_PI)), 0.5);
  for (int i = 0; i < 5; ++i) ASSERT_EQ(environment.Step(ahead.data()).end, SegmentEnd::kNone);
  EXPECT_GT(environment.pose().x, 0.3);
}

// Between two walls, with a third ahead, while something turns the car by 0.4 rad/s, as a held disturbance does.
// Opposite corners would touch within 0.4 s, there is nothing to back off to, and what is commanded is no help.
TEST(SafetyFilterTest, TurnsAgainstADisturbanceThatStays) {
  Experiment experiment = FilteredHall();
  experiment.world.obstacles = {
      {{1.4, 0.4, 0}, {1.6, 0.4705, 0}}, {{1.4, 0.5295, 0}, {1.6, 0.6, 0}}, {{1.59, 0.47, 0}, {1.6, 0.53, 0}}};
  const auto scene = MakeScene(experiment);
  const auto vehicle = MakeVehicle(scene->experiment().vehicle, scene->experiment().environment);
  RandomStream random(0, RandomPurpose::kTest);
  SafetyFilter filter(*scene);
  RangeFinder ranges(*scene);
  for (const VehicleCommand wanted : {VehicleCommand{0, 0}, {0, 2}, {0.6, 1.1}, {0.6, -1.1}}) {
    vehicle->Reset({1.5, 0.5, 0, 0}, random);
    filter.Reset();
    for (int step = 0; step < 480; step += filter.period()) {
      VehicleCommand command = filter.Apply({wanted, *vehicle, vehicle->motion(), 0, step}, ranges);
      command[1] += 0.4;
      vehicle->Command(command);
      for (int i = 0; i < filter.period(); ++i) vehicle->Step();
      const Motion m = vehicle->motion();
      ASSERT_FALSE(scene->obstacles().Overlaps(m.x, m.y, m.yaw, scene->footprint())) << step << " " << wanted[1];
    }
  }
}

TEST(SafetyFilterTest, EvaluationAloneIsFilteredWhenAskedFor) {
  Experiment experiment = FilteredHall();
  experiment.safety.filter = SafetyConfig::Filter::kEvaluation;
  experiment.environment.max_episode_steps = 60;
  const auto scene = MakeScene(experiment);
  Environment environment(scene);
  const Action ahead(1, 0);
  const auto run = [&] {
    while (environment.Step(ahead.data()).end == SegmentEnd::kNone) {
    }
    return environment.episode();
  };
  int hits = 0;
  for (int episode = 0; episode < 10; ++episode) {
    environment.ResetTraining(0, episode);
    const EpisodeResult trained = run();
    EXPECT_EQ(trained.filtered_steps, 0);
    hits += trained.outcome == Outcome::kCollision;
    environment.ResetEvaluation(StartSet::kTest, episode, 0);
    EXPECT_NE(run().outcome, Outcome::kCollision);
  }
  EXPECT_GT(hits, 5);
}

}  // namespace
}  // namespace cairn::actors
