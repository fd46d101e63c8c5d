#include "actors/range_finder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

const Vector3d kMiddle(1.5, 0.5, 0), kLeft(0, 1, 0), kAhead(1, 0, 0);

RandomStream Noise() { return {1, RandomPurpose::kRanges}; }

TEST(RangeFinderTest, NoiseHasItsDeviationAndLostRaysSeeNothing) {
  Experiment experiment = HallExperiment();
  experiment.observation.range_noise = 0.01;
  experiment.observation.range_dropout = 0.25;
  const auto scene = MakeScene(experiment);
  RangeFinder ranges(*scene, nullptr, Noise(), 0);
  int lost = 0, seen = 0;
  double squares = 0;
  for (int i = 0; i < 8000; ++i) {
    const double range = ranges.Range(kMiddle, kLeft, 0.8);
    if (range == 0.8) {
      ++lost;
    } else {
      ++seen;
      squares += std::pow(range - 0.5, 2);
    }
  }
  EXPECT_NEAR(lost, 2000, 5 * std::sqrt(8000 * 0.25 * 0.75));
  EXPECT_NEAR(std::sqrt(squares / seen), 0.01, 0.0005);
}

TEST(RangeFinderTest, ARayThatReachesNothingStaysSo) {
  Experiment experiment = HallExperiment();
  experiment.observation.range_noise = 0.01;
  const auto scene = MakeScene(experiment);
  RangeFinder ranges(*scene, nullptr, Noise(), 0);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(ranges.Range(kMiddle, kAhead, 0.4), 0.4);
}

TEST(RangeFinderTest, ALookIsTheSameWheneverItIsTakenAndLooksDiffer) {
  Experiment experiment = HallExperiment();
  experiment.observation.range_noise = 0.01;
  const auto scene = MakeScene(experiment);
  const auto look = [&](uint64_t number) {
    RangeFinder ranges(*scene, nullptr, Noise(), number);
    return std::pair(ranges.Range(kMiddle, kLeft, 0.8), ranges.Range(kMiddle, kLeft, 0.8));
  };
  EXPECT_EQ(look(3), look(3));
  EXPECT_NE(look(3), look(4));
  EXPECT_NE(look(3).first, look(3).second);
}

}  // namespace
}  // namespace cairn::actors
