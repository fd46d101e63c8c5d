// Episodes with what a real robot brings: delay, noise, slip, a body that is larger than described.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "actors/environment.h"
#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

TEST(DisturbedEnvironmentTest, ADelayedActionArrivesStepsLater) {
  Experiment experiment = HallExperiment();
  experiment.environment.action_delay_steps = 2;
  const auto scene = MakeScene(experiment);
  Environment environment(scene);
  environment.ResetEvaluation(StartSet::kTest, StartTowardsGoal(*scene), 0);
  const double from = environment.pose().x;
  std::vector<double> speeds;
  for (const double speed : {0.5, 0.25, 0.0, 0.0, 0.0}) {
    const Action action(speed, 0);
    environment.Step(action.data());
    speeds.push_back(environment.motion().vx);
  }
  EXPECT_EQ(speeds, (std::vector<double>{0, 0, 0.5, 0.25, 0}));
  EXPECT_NEAR(environment.episode().path_length, 0.075, 1e-5);
  EXPECT_GT(environment.pose().x, from);
}

TEST(DisturbedEnvironmentTest, ObservationNoiseIsTheSameWheneverOneLooks) {
  Experiment experiment = HallExperiment();
  experiment.environment.observation_noise = 0.1;
  const auto scene = MakeScene(experiment);
  Environment environment(scene);
  double squares = 0;
  int count = 0;
  for (int episode = 0; episode < 40; ++episode) {
    environment.ResetTraining(0, episode);
    const std::vector<float> first = Observe(environment);
    EXPECT_EQ(first, Observe(environment));
    const Action stop(0, 0);
    environment.Step(stop.data());
    const std::vector<float> second = Observe(environment);
    for (size_t i = 0; i < first.size(); ++i) {  // the vehicle stands: only the noise differs
      EXPECT_NE(first[i], second[i]);
      squares += std::pow(first[i] - second[i], 2);
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), 0.1 * std::sqrt(2), 0.01);
}

// With a believed pose far off the reward stays that of the truth, and the observation does not.
TEST(DisturbedEnvironmentTest, NoiseOfThePoseIsInTheBeliefAndNotInTheReward) {
  Experiment noisy = HallExperiment();
  noisy.observation.pose_noise = 0.3;
  noisy.observation.heading_noise = 0.5;
  Environment exact(MakeScene(HallExperiment())), blurred(MakeScene(noisy));
  for (int episode = 0; episode < 5; ++episode) {
    exact.ResetTraining(0, episode);
    blurred.ResetTraining(0, episode);
    const Action ahead(0.5, 0.3);
    for (int i = 0; i < 10 && exact.episode().outcome == Outcome::kRunning; ++i) {
      EXPECT_EQ(exact.Step(ahead.data()).reward, blurred.Step(ahead.data()).reward);
      EXPECT_EQ(exact.pose().x, blurred.pose().x);
      EXPECT_EQ(exact.d_min(), blurred.d_min());
      EXPECT_NE(exact.believed_pose().x, blurred.believed_pose().x);
      EXPECT_EQ(exact.believed_pose().x, exact.pose().x);
    }
    const std::vector<float> a = Observe(exact), b = Observe(blurred);
    EXPECT_EQ(b, Observe(blurred));
    EXPECT_NE(a[0], b[0]) << "heading";
    EXPECT_EQ(a[2], b[2]) << "speed";
    EXPECT_EQ(a.back(), b.back()) << "rays";
  }
}

TEST(DisturbedEnvironmentTest, ALargerFootprintTouchesSooner) {
  double reached[2];
  for (const double scale : {1.0, 1.2}) {
    Experiment experiment = HallExperiment();
    experiment.environment.footprint_scale = scale;
    const auto scene = MakeScene(experiment);
    Environment environment(scene);
    environment.ResetEvaluation(StartSet::kTest, StartTowardsWall(*scene), 0);
    const Action ahead(1, 0);
    while (environment.Step(ahead.data()).end == SegmentEnd::kNone) {
    }
    EXPECT_EQ(environment.episode().outcome, Outcome::kCollision);
    reached[scale > 1] = environment.pose().x;
  }
  EXPECT_NEAR(reached[1] - reached[0], 0.2 * 0.035, 1.0 / 240 + 1e-6);
}

TEST(DisturbedEnvironmentTest, SlipLosesAShareOfTheMotion) {
  Experiment experiment = HallExperiment();
  experiment.environment.slip = 0.5;
  const auto scene = MakeScene(experiment);
  Environment environment(scene);
  double sum = 0;
  int steps = 0;
  for (int episode = 0; episode < 100; ++episode) {
    environment.ResetTraining(0, episode);
    const Action slow(0.2, 0);
    for (int i = 0; i < 4 && environment.Step(slow.data()).end == SegmentEnd::kNone; ++i, ++steps) {
      EXPECT_GE(environment.motion().vx, 0.1 - 1e-9);
      EXPECT_LE(environment.motion().vx, 0.2 + 1e-9);
      sum += environment.motion().vx;
    }
  }
  EXPECT_NEAR(sum / steps, 0.15, 0.01);
}

TEST(DisturbedEnvironmentTest, ADelayInSecondsIsKeptToThePhysicsStep) {
  Experiment experiment = HallExperiment();
  experiment.environment.action_delay = 0.15;
  const auto scene = MakeScene(experiment);
  Environment environment(scene);
  environment.ResetEvaluation(StartSet::kTest, StartTowardsGoal(*scene), 0);
  const Action go(0.5, 0), stop(0, 0);
  environment.Step(go.data());
  environment.Step(stop.data());
  EXPECT_NEAR(environment.episode().path_length, 0.025, 1e-5);  // from 0.15 s to 0.2 s
  environment.Step(stop.data());
  environment.Step(stop.data());
  EXPECT_NEAR(environment.episode().path_length, 0.05, 1e-5);
}

TEST(DisturbedEnvironmentTest, TheLastActionsAreSeenNewestFirst) {
  Experiment experiment = HallExperiment();
  const size_t without = static_cast<size_t>(ObservationSize(experiment));
  experiment.observation.last_actions = 2;
  const auto scene = MakeScene(experiment);
  Environment environment(scene);
  const auto last = [&] {
    const std::vector<float> all = Observe(environment);
    return std::vector<float>(all.begin() + static_cast<ptrdiff_t>(without), all.end());
  };
  for (int episode = 0; episode < 2; ++episode) {
    environment.ResetEvaluation(StartSet::kTest, StartTowardsGoal(*scene), episode);
    EXPECT_EQ(last(), (std::vector<float>{0, 0, 0, 0}));
    const float first[] = {-1, 0.5f}, second[] = {-0.75f, 0.25f}, third[] = {-1, 0};
    environment.Step(first);
    EXPECT_EQ(last(), (std::vector<float>{-1, 0.5f, 0, 0}));
    environment.Step(second);
    EXPECT_EQ(last(), (std::vector<float>{-0.75f, 0.25f, -1, 0.5f}));
    environment.Step(third);
    EXPECT_EQ(last(), (std::vector<float>{-1, 0, -0.75f, 0.25f}));
  }
}

}  // namespace
}  // namespace cairn::actors
