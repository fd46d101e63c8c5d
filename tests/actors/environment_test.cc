#include "actors/environment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/core/check.h"
#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

// Everything that can be seen of an episode, step by step, until it ends or `steps` are done.
struct Trace {
  std::vector<float> rewards;
  std::vector<std::vector<float>> observations;
  std::vector<double> poses;
  std::string last;
  bool operator==(const Trace&) const = default;
};

Trace Drive(Environment& environment, RandomStream random, int steps) {
  Trace trace;
  for (int i = 0; i < steps && environment.episode().outcome == Outcome::kRunning; ++i) {
    const Action action(random.Uniform(0, 1), random.Uniform(-2, 2));
    trace.rewards.push_back(environment.Step(action.data()).reward);
    trace.observations.push_back(Observe(environment));
    const Pose pose = environment.pose();
    for (const double value : {pose.x, pose.y, pose.yaw}) trace.poses.push_back(value);
  }
  trace.last = environment.Save();
  return trace;
}

RandomStream Actions(uint32_t index = 0) { return {1, RandomPurpose::kTest, index}; }

TEST(EnvironmentTest, AWallEndsTheEpisodeWithinTheControlStep) {
  const auto scene = MakeScene(HallExperiment());
  Environment environment(scene);
  environment.ResetEvaluation(StartSet::kTest, StartTowardsWall(*scene), 0);
  const Pose start = environment.pose();
  const Action ahead(1, 0);
  StepResult result;
  do {
    result = environment.Step(ahead.data());
  } while (result.end == SegmentEnd::kNone);
  EXPECT_EQ(result.end, SegmentEnd::kTerminated);
  EXPECT_EQ(result.reward, -2);
  const EpisodeResult& episode = environment.episode();
  EXPECT_EQ(episode.outcome, Outcome::kCollision);
  EXPECT_EQ(episode.min_clearance, 0);
  // Half a length before the wall, found within one physics step (1/240 s at 1 m/s), and the clock stops there.
  const double cosine = std::abs(std::cos(start.yaw)), sine = std::abs(std::sin(start.yaw));
  const double reach = 0.035 * cosine + 0.025 * sine;
  EXPECT_NEAR(environment.pose().x, reach, cosine / 240 + 1e-6);
  EXPECT_NEAR(episode.duration, (start.x - environment.pose().x) / cosine, 1e-3);
  EXPECT_EQ(episode.steps, static_cast<int>(std::ceil(episode.duration / 0.1 - 1e-6)));
}

// With its feet 6 mm apart it cannot keep upright. Nothing is near, so the clearance stays.
TEST(EnvironmentTest, AFallEndsTheEpisodeLikeAWall) {
  Experiment experiment = HallExperiment();
  experiment.vehicle.kind = VehicleConfig::Kind::kQuadruped;
  experiment.vehicle.length = 0.06;
  experiment.vehicle.width = 0.006;
  experiment.vehicle.max_speed = 0.3;
  experiment.environment.physics_rate_hz = 120;
  const auto scene = MakeScene(experiment);
  Environment environment(scene);
  environment.ResetEvaluation(
      StartSet::kTest,
      FindEvaluationStart(*scene, [](const Pose& p) { return p.x > 1 && p.x < 2 && p.y > 0.4 && p.y < 0.6; }), 0);
  const Action turn_right(1, -2);
  StepResult result;
  do {
    result = environment.Step(turn_right.data());
  } while (result.end == SegmentEnd::kNone);
  EXPECT_EQ(result.end, SegmentEnd::kTerminated);
  EXPECT_EQ(result.reward, -2);
  EXPECT_EQ(environment.episode().outcome, Outcome::kCollision);
  EXPECT_GT(environment.episode().min_clearance, 0.1);
}

TEST(EnvironmentTest, TheGoalEndsTheEpisodeWithinTheControlStep) {
  const auto scene = MakeScene(HallExperiment());
  Environment environment(scene);
  environment.ResetEvaluation(StartSet::kTest, StartTowardsGoal(*scene), 0);
  const Pose start = environment.pose();
  const Action ahead(1, 0);
  StepResult result;
  double sum = 0;
  do {
    result = environment.Step(ahead.data());
    sum += result.reward;
  } while (result.end == SegmentEnd::kNone);
  EXPECT_EQ(result.end, SegmentEnd::kTerminated);
  EXPECT_EQ(result.reward, 10);
  const EpisodeResult& episode = environment.episode();
  EXPECT_EQ(episode.outcome, Outcome::kGoal);
  EXPECT_NEAR(environment.pose().x, 2.6, 1.0 / 240 + 1e-6);
  EXPECT_FLOAT_EQ(episode.episode_return, static_cast<float>(sum));
  // A straight line at 1 m/s without lag: way, time and clearance by hand.
  const double way = (environment.pose().x - start.x) / std::cos(start.yaw);
  EXPECT_NEAR(episode.path_length, way, 1e-4);
  EXPECT_NEAR(episode.duration, way, 1e-4);
  EXPECT_NEAR(episode.shortest_length, scene->lookup().CostToGo(Vector3d(start.x, start.y, 0)), 1e-6);
  // Nearest in the end: the wall at x = 3 m, before the bumper.
  EXPECT_NEAR(episode.min_clearance, 3 - environment.pose().x - 0.035 - 0.025 * std::abs(start.yaw), 0.002);
}

TEST(EnvironmentTest, TheStepLimitTruncates) {
  Experiment experiment = HallExperiment();
  experiment.environment.max_episode_steps = 7;
  experiment.evaluation.max_steps = 5;
  Environment environment(MakeScene(experiment));
  const Action stop(0, 0);
  for (const bool training : {true, false}) {
    training ? environment.ResetTraining(0, 0) : environment.ResetEvaluation(StartSet::kValidation, 0, 0);
    StepResult result;
    do {
      result = environment.Step(stop.data());
      EXPECT_EQ(result.reward, 0);
    } while (result.end == SegmentEnd::kNone);
    EXPECT_EQ(result.end, SegmentEnd::kTruncated);
    EXPECT_EQ(environment.episode().outcome, Outcome::kTimeout);
    EXPECT_EQ(environment.episode().steps, training ? 7 : 5);
    EXPECT_NEAR(environment.episode().duration, training ? 0.7 : 0.5, 1e-6);
  }
}

// D_min⁰ = D(s₀) pays nothing; then every control step whose end has a smaller D pays R_+, whatever the drop.
TEST(EnvironmentTest, ProgressIsPaidWhenDMinDrops) {
  const auto scene = MakeScene(HallExperiment());
  Environment environment(scene);
  environment.ResetEvaluation(StartSet::kTest, StartTowardsGoal(*scene), 0);
  const auto distance = [&] {
    return scene->lookup().CostToGo(Vector3d(environment.pose().x, environment.pose().y, 0));
  };
  float d_min = distance();
  EXPECT_EQ(environment.d_min(), d_min);
  int drops = 0;
  for (const double speed : {0.0, 0.3, 0.02, 1.0, 0.0, 0.5}) {
    const Action action(speed, 0);
    const StepResult result = environment.Step(action.data());
    ASSERT_EQ(result.end, SegmentEnd::kNone);
    EXPECT_EQ(result.reward, distance() < d_min ? 1 : 0);
    drops += distance() < d_min;
    d_min = std::min(d_min, distance());
    EXPECT_EQ(environment.d_min(), d_min);
  }
  EXPECT_GE(drops, 2);
  EXPECT_FLOAT_EQ(environment.episode().episode_return, static_cast<float>(drops));
}

// Nothing within r_ball at the start: D_min is infinite, and the first finite value is a drop; back in the void D_min
// stays.
TEST(EnvironmentTest, TheFirstFiniteDistanceIsADrop) {
  auto scene = std::make_shared<Scene>(HallExperiment());
  const int index = StartTowardsGoal(*scene);
  const Pose start = scene->EvaluationStart(StartSet::kTest, index);
  const float ahead = static_cast<float>(start.x + 0.2), y = static_cast<float>(start.y + 0.2 * std::tan(start.yaw));
  scene->SetTable(MakeChain(scene->world().goal, {ahead, 2.7f}, y, 0.03));
  Environment environment(scene);
  environment.ResetEvaluation(StartSet::kTest, index, 0);
  EXPECT_EQ(environment.d_min(), kUnreachable);
  // The length of the way to the goal still has a number, through the nearest vertex.
  EXPECT_NEAR(environment.episode().shortest_length, 2.7 - start.x, 0.02);
  const Action action(1, 0);
  EXPECT_EQ(environment.Step(action.data()).reward, 0);
  EXPECT_EQ(environment.Step(action.data()).reward, 1);
  const float found = environment.d_min();
  EXPECT_NEAR(found, 2.7 - ahead, 1e-6);
  EXPECT_EQ(environment.Step(action.data()).reward, 0);
  EXPECT_EQ(environment.d_min(), found);
}

TEST(EnvironmentTest, ANewTableResetsDMinWithoutReward) {
  const auto scene = MakeScene(HallExperiment());
  Environment environment(scene);
  const int index = StartTowardsGoal(*scene);
  environment.ResetEvaluation(StartSet::kTest, index, 0);
  const Action action(0.5, 0);
  environment.Step(action.data());
  const float before = environment.episode().episode_return;
  const Pose pose = environment.pose();
  const auto y = static_cast<float>(pose.y);
  environment.SetTable(MakeChain(scene->world().goal, {static_cast<float>(pose.x), 0.2f, 2.7f}, y, 0.05));
  EXPECT_NEAR(environment.d_min(), (pose.x - 0.2) * -1 + 2.5, 1e-5);
  EXPECT_EQ(environment.episode().episode_return, before);
}

TEST(EnvironmentTest, NoTunnellingThroughThinWallsAtFiveMetresASecond) {
  for (const auto kind : {VehicleConfig::Kind::kPlaneCar, VehicleConfig::Kind::kWheeledCar}) {
    Experiment experiment = HallExperiment();
    experiment.world.obstacles = {{{1.4, 0, 0}, {1.42, 0.9, 0}}};  // leaves a gap, so that the goal is reachable
    experiment.vehicle.kind = kind;
    experiment.vehicle.max_speed = 5;
    const auto scene = MakeScene(experiment);
    Environment environment(scene);
    int hits = 0;
    for (int index = 0; index < 300; ++index) {
      const Pose start = scene->EvaluationStart(StartSet::kTest, index);
      // Straight at the wall, well below the gap's edge.
      const double reach = (1.4 - start.x) / std::cos(start.yaw);
      const double hit_y = start.y + reach * std::sin(start.yaw);
      if (start.x > 1.2 || std::abs(start.yaw) > 1.0 || hit_y < 0.1 || hit_y > 0.8) continue;
      environment.ResetEvaluation(StartSet::kTest, index, 0);
      const float ahead[] = {1, 0};
      while (environment.Step(ahead).end == SegmentEnd::kNone) {
      }
      EXPECT_EQ(environment.episode().outcome, Outcome::kCollision) << index;
      EXPECT_LT(environment.pose().x, 1.41) << index;
      ++hits;
    }
    EXPECT_GT(hits, 10);
  }
}

TEST(EnvironmentTest, ANonFiniteActionDiverges) {
  const auto scene = MakeScene(NoisyMazeExperiment());
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    for (int entry = 0; entry < 2; ++entry) {
      Environment environment(scene);
      environment.ResetTraining(0, 0);
      float action[] = {0, 0};
      action[entry] = bad;
      const StepResult result = environment.Step(action);
      EXPECT_EQ(result.end, SegmentEnd::kTruncated);
      EXPECT_EQ(result.reward, 0);
      EXPECT_EQ(environment.episode().outcome, Outcome::kDiverged);
      for (const float value : Observe(environment)) EXPECT_TRUE(std::isfinite(value));
      // And leaves no trace in the next episode.
      environment.ResetTraining(2, 3);
      Environment fresh(scene);
      fresh.ResetTraining(2, 3);
      EXPECT_EQ(Drive(environment, Actions(), 20), Drive(fresh, Actions(), 20));
    }
  }
}

TEST(EnvironmentTest, SavesAndLoadsBitForBitInMidEpisode) {
  for (const auto kind : {VehicleConfig::Kind::kWheeledCar, VehicleConfig::Kind::kPlaneCar}) {
    Experiment experiment = NoisyMazeExperiment();
    experiment.vehicle.kind = kind;
    const auto scene = MakeScene(experiment);
    Environment environment(scene);
    for (int episode = 0; episode < 5; ++episode) {
      environment.ResetTraining(1, episode);
      Drive(environment, Actions(1), 3);
      const std::string blob = environment.Save();
      Environment other(scene);
      other.ResetEvaluation(StartSet::kTest, 5, 1);
      Drive(other, Actions(2), 2);
      other.Load(blob);
      EXPECT_EQ(other.Save(), blob);
      EXPECT_EQ(Observe(other), Observe(environment));
      EXPECT_EQ(Drive(other, Actions(3), 50), Drive(environment, Actions(3), 50));
    }
  }
}

TEST(EnvironmentTest, LoadRefusesWhatDoesNotFit) {
  const auto scene = MakeScene(NoisyMazeExperiment());
  Environment environment(scene);
  environment.ResetTraining(0, 0);
  const std::string blob = environment.Save();
  EXPECT_THROW(environment.Load(blob.substr(0, blob.size() / 2)), Error);
  Experiment other = NoisyMazeExperiment();
  other.environment.action_delay_steps = 0;
  Environment without_delay(MakeScene(other));
  EXPECT_THROW(without_delay.Load(blob), Error);
}

TEST(EnvironmentTest, TheResultDoesNotDependOnWhichObjectRunsIt) {
  const auto scene = MakeScene(NoisyMazeExperiment());
  Environment busy(scene);
  for (int episode = 0; episode < 4; ++episode) {
    busy.ResetTraining(7, episode);
    Drive(busy, Actions(9), 15);
  }
  for (const bool training : {true, false}) {
    Environment fresh(scene);
    for (Environment* environment : {&busy, &fresh}) {
      training ? environment->ResetTraining(3, 11) : environment->ResetEvaluation(StartSet::kConsumption, 4, 6);
    }
    const Trace expected = Drive(fresh, Actions(4), 60);
    EXPECT_EQ(Drive(busy, Actions(4), 60), expected);
    EXPECT_GE(expected.rewards.size(), 2u);
  }
}

TEST(EnvironmentTest, EvaluationsDifferInTheirDisturbanceAlone) {
  const auto scene = MakeScene(Experiment{});
  Environment a(scene), b(scene);
  a.ResetEvaluation(StartSet::kTest, 4, 0);
  b.ResetEvaluation(StartSet::kTest, 4, 1);
  EXPECT_EQ(a.pose().x, b.pose().x);
  EXPECT_EQ(a.pose().yaw, b.pose().yaw);
  const Action action(0.3, 0.5);
  a.Step(action.data());
  b.Step(action.data());
  EXPECT_NE(a.pose().yaw, b.pose().yaw);
}

TEST(EnvironmentTest, ActionsOutsideTheRangeAreClipped) {
  const auto scene = MakeScene(HallExperiment());
  Environment a(scene), b(scene);
  const int index = StartTowardsGoal(*scene);
  a.ResetEvaluation(StartSet::kTest, index, 0);
  b.ResetEvaluation(StartSet::kTest, index, 0);
  const float wild[] = {17, -5}, edge[] = {1, -1};
  a.Step(wild);
  b.Step(edge);
  EXPECT_EQ(a.Save(), b.Save());
}

// Velocity 0, 0.5, 0.5, 0.5 m/s at the control steps' ends: second differences over period², first from rest:
// |0.5 − 2·0 …| with v₋₁ = 0 at the start gives (0.5 − 2·0.5 + 0)/0.01 = 50 once, then 0: a mean of 25 over two.
TEST(EnvironmentTest, JerkIsTheSecondDifferenceOfVelocity) {
  const auto scene = MakeScene(HallExperiment());
  Environment environment(scene);
  environment.ResetEvaluation(StartSet::kTest, StartTowardsGoal(*scene), 0);
  const Action action(0.5, 0);
  for (int i = 0; i < 3; ++i) environment.Step(action.data());
  EXPECT_NEAR(environment.episode().mean_jerk, 25, 1e-3);
}

TEST(EnvironmentTest, TheTrainingLimitComesFromTheRoadmap) {
  Experiment experiment = HallExperiment();
  experiment.environment.max_episode_steps = 0;
  auto scene = std::make_shared<Scene>(experiment);
  scene->SetTable(MakeChain(scene->world().goal, {0.5f, 0.6f, 2.7f}, 0.5f, 0.05));
  Environment environment(scene);
  environment.ResetTraining(0, 0);
  const Action stop(0, 0);
  while (environment.Step(stop.data()).end == SegmentEnd::kNone) {
  }
  EXPECT_EQ(environment.episode().steps, 132);  // 6 · 2.2 m / (1 m/s · 0.1 s)
}

}  // namespace
}  // namespace cairn::actors
