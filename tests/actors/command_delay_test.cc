#include "actors/command_delay.h"

#include <gtest/gtest.h>

#include <set>

namespace cairn::actors {
namespace {

constexpr int kControlSteps = 24;  // 0.1 s at 240 Hz

Experiment Delayed(double seconds, double spread = 0) {
  Experiment experiment;
  experiment.environment.action_delay = seconds;
  experiment.environment.action_delay_spread = spread;
  return experiment;
}

RandomStream Parameters(uint32_t episode = 0) { return {1, RandomPurpose::kParameters, 0, episode}; }

TEST(CommandDelayTest, WithoutOneEachCommandHoldsForItsStep) {
  const Experiment experiment;
  CommandDelay delay(experiment, kControlSteps);
  RandomStream parameters = Parameters();
  delay.Reset(parameters);
  EXPECT_EQ(parameters.position(), 0u);
  for (int step = 0; step < 5; ++step) {
    delay.Push(step, {static_cast<double>(step), 0, 0});
    EXPECT_EQ(delay.InForce(step, 0), step);
    EXPECT_EQ(delay.InForce(step, kControlSteps - 1), step);
    EXPECT_EQ(delay.command(step)[0], step);
  }
}

// 0.25 s = 60 physics steps: two control steps and a half.
TEST(CommandDelayTest, PartsOfAControlStepCount) {
  const Experiment experiment = Delayed(0.25);
  CommandDelay delay(experiment, kControlSteps);
  RandomStream parameters = Parameters();
  delay.Reset(parameters);
  for (int step = 0; step < 8; ++step) {
    delay.Push(step, {1.0 + step, 0, 0});
    EXPECT_EQ(delay.InForce(step, 11), step < 3 ? -1 : step - 3) << step;
    EXPECT_EQ(delay.InForce(step, 12), step < 2 ? -1 : step - 2) << step;
    EXPECT_EQ(delay.command(delay.InForce(step, 11))[0], step < 3 ? 0 : step - 2) << step;
  }
}

TEST(CommandDelayTest, EpisodesDifferWithinTheSpread) {
  const Experiment experiment = Delayed(0.05, 0.05);
  CommandDelay delay(experiment, kControlSteps);
  std::set<int64_t> delays;
  for (uint32_t episode = 0; episode < 200; ++episode) {
    RandomStream parameters = Parameters(episode);
    delay.Reset(parameters);
    int64_t physics_step = 0;
    while (delay.InForce(static_cast<int>(physics_step / kControlSteps), physics_step % kControlSteps) < 0)
      ++physics_step;
    delays.insert(physics_step);
  }
  EXPECT_GE(*delays.begin(), 0);
  EXPECT_LE(*delays.rbegin(), 24);
  EXPECT_GT(delays.size(), 20u);
}

}  // namespace
}  // namespace cairn::actors
