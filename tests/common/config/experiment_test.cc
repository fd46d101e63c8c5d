#include "common/config/experiment.h"

#include <gtest/gtest.h>

namespace cairn {
namespace {

TEST(ExperimentTest, RadiiOfTheFootprint) {
  VehicleConfig vehicle;
  vehicle.length = 0.08;
  vehicle.width = 0.06;
  EXPECT_DOUBLE_EQ(vehicle.inscribed_radius(), 0.03);
  EXPECT_DOUBLE_EQ(vehicle.circumscribed_radius(), 0.05);
}

TEST(ExperimentTest, ObservationSizeCountsItsParts) {
  Experiment experiment;
  EXPECT_EQ(ObservationSize(experiment), 2 + 2 + 1 + 4 + 16);
  experiment.observation.position = true;
  experiment.vehicle.scan.beams = 8;
  EXPECT_EQ(ObservationSize(experiment), 2 + 2 + 2 + 1 + 4 + 8);
  experiment.observation = {true, true, true, true, false, false};
  EXPECT_EQ(ObservationSize(experiment), 7);
}

TEST(ExperimentTest, EpisodeStepsFollowTheRoadmapUnlessTyped) {
  Experiment experiment;
  EXPECT_EQ(EpisodeSteps(experiment, 5.0), 300);
  EXPECT_EQ(EpisodeSteps(experiment, 5.001), 301);
  experiment.vehicle.max_speed = 2.0;
  EXPECT_EQ(EpisodeSteps(experiment, 5.0), 150);
  EXPECT_EQ(EpisodeSteps(experiment, 0.0), 1);
  experiment.environment.max_episode_steps = 42;
  EXPECT_EQ(EpisodeSteps(experiment, 5.0), 42);
}

}  // namespace
}  // namespace cairn
