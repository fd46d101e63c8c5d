#include "actors/localization.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cairn::actors {
namespace {

Localization Make(const Experiment& experiment, uint32_t episode = 0) {
  Localization localization(experiment);
  localization.Reset({1, RandomPurpose::kLocalization, 0, episode});
  return localization;
}

TEST(LocalizationTest, BelievesTheTruthUnlessToldOtherwise) {
  const Experiment experiment;
  const Localization localization = Make(experiment);
  EXPECT_FALSE(localization.active());
  const Pose believed = localization.Believe({1, 2, 3, 4}, 5);
  EXPECT_EQ(believed.x, 1);
  EXPECT_EQ(believed.yaw, 3);
  EXPECT_EQ(believed.z, 4);
}

TEST(LocalizationTest, NoiseHasItsDeviationAndIsTheSameWheneverAsked) {
  Experiment experiment;
  experiment.observation.pose_noise = 0.02;
  experiment.observation.heading_noise = 0.1;
  const Localization localization = Make(experiment);
  double x = 0, yaw = 0, last = 0;
  const int n = 4000;
  for (int step = 0; step < n; ++step) {
    const Pose believed = localization.Believe({}, step);
    EXPECT_EQ(believed.x, localization.Believe({}, step).x);
    EXPECT_NE(believed.x, last);
    EXPECT_EQ(believed.z, 0) << "in the plane";
    last = believed.x;
    x += believed.x * believed.x;
    yaw += believed.yaw * believed.yaw;
  }
  EXPECT_NEAR(std::sqrt(x / n), 0.02, 0.02 * 0.05);
  EXPECT_NEAR(std::sqrt(yaw / n), 0.1, 0.1 * 0.05);
}

// One jump in 2 s on average, steps of 0.1 s: a share of 1 − e^(−1/20) of the steps.
TEST(LocalizationTest, JumpsStayUntilTheNext) {
  Experiment experiment;
  experiment.observation.pose_jump = 0.5;
  experiment.observation.pose_jump_interval = 2;
  Localization localization = Make(experiment);
  EXPECT_EQ(localization.Believe({}, 0).x, 0);
  int jumps = 0;
  double last = 0;
  const int n = 10000;
  for (int step = 1; step <= n; ++step) {
    localization.Advance(step);
    const double x = localization.Believe({}, step).x;
    jumps += x != last;
    last = x;
  }
  EXPECT_NEAR(jumps, n * (1 - std::exp(-0.05)), 5 * std::sqrt(n * 0.05));
}

// Of independent errors with deviation σ a first-order filter leaves σ √((1 − g) / (1 + g)).
TEST(LocalizationTest, AFilterLeavesAThirdOfTheNoiseAndFollowsJumps) {
  Experiment experiment;
  experiment.observation.pose_noise = 0.02;
  experiment.observation.pose_filter = 0.8;
  Localization localization = Make(experiment);
  EXPECT_NE(localization.Believe({}, 0).x, 0) << "the first measurement";
  double squares = 0;
  const int n = 20000;
  for (int step = 1; step <= n; ++step) {
    localization.Advance(step);
    const double x = localization.Believe({}, step).x;
    EXPECT_EQ(x, localization.Believe({}, step).x);
    squares += x * x;
  }
  EXPECT_NEAR(std::sqrt(squares / n), 0.02 / 3, 0.02 / 3 * 0.05);

  experiment.observation.pose_noise = 0;
  experiment.observation.pose_jump = 0.5;
  experiment.observation.pose_jump_interval = 1e-3;  // before every step
  Localization jumping = Make(experiment);
  jumping.Advance(1);
  Experiment unfiltered = experiment;
  unfiltered.observation.pose_filter = 0;
  Localization plain = Make(unfiltered);
  plain.Advance(1);
  EXPECT_NEAR(jumping.Believe({}, 1).x, 0.2 * plain.Believe({}, 1).x, 1e-12);
}

TEST(LocalizationTest, GoesOnAfterRead) {
  Experiment experiment;
  experiment.observation.pose_filter = 0.5;
  experiment.observation.pose_jump = 0.5;
  experiment.observation.heading_jump = 0.5;
  experiment.observation.pose_jump_interval = 0.2;
  Localization a = Make(experiment), b = Make(experiment);
  for (int step = 1; step <= 10; ++step) a.Advance(step);
  BlobWriter writer;
  a.Write(writer);
  const std::string blob = writer.Take();
  BlobReader reader(blob);
  b.Read(reader);
  EXPECT_NE(a.Believe({}, 10).yaw, 0);
  EXPECT_EQ(a.Believe({}, 10).yaw, b.Believe({}, 10).yaw);
}

}  // namespace
}  // namespace cairn::actors
