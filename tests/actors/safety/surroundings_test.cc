#include "actors/safety/surroundings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

std::vector<Sighting> Look(const Experiment& experiment, const Motion& motion, double reach) {
  const auto scene = MakeScene(experiment);
  RangeFinder ranges(*scene);
  Surroundings surroundings(experiment);
  surroundings.Look(motion, reach, ranges);
  return surroundings.sightings();
}

// A vehicle 60 mm below the wall y = 1 that looks along it: all that is seen lies on the wall, without a gap, in its
// own frame; what two beams leave between them is half unseen where the line runs straight on.
TEST(SurroundingsTest, AWallIsALineWithoutGaps) {
  const std::vector<Sighting> wall = Look(HallExperiment(), GroundState{1.5, 0.94, M_PI / 2}, 0.2);
  const double width = std::sqrt(0.2 * 0.2 - 0.06 * 0.06);
  std::vector<double> along;
  for (const Sighting& sighting : wall) {
    EXPECT_NEAR(sighting.p.x(), 0.06, 1e-9);
    along.push_back(sighting.p.y());
    if (sighting.p.norm() > 0.1) continue;
    EXPECT_NEAR(sighting.unseen, 0.5 * sighting.p.norm() * M_PI / 90, 1e-4);
  }
  std::sort(along.begin(), along.end());
  ASSERT_GT(along.size(), 40u);
  EXPECT_NEAR(along.front(), -width, 0.025);
  EXPECT_NEAR(along.back(), width, 0.025);
  for (size_t i = 1; i < along.size(); ++i) EXPECT_LT(along[i] - along[i - 1], 0.0044);
}

// Two posts with a gap that the car (50 mm wide) passes, and then one that it does not.
TEST(SurroundingsTest, OnlyGapsTooNarrowToPassAreClosed) {
  for (const double half_gap : {0.04, 0.02}) {
    Experiment experiment = HallExperiment();
    experiment.world.obstacles = {{{1.6, 0.4, 0}, {1.62, 0.5 - half_gap, 0}},
                                  {{1.6, 0.5 + half_gap, 0}, {1.62, 0.6, 0}}};
    int inside = 0;
    for (const Sighting& sighting : Look(experiment, GroundState{1.5, 0.5, 0}, 0.2)) {
      inside += sighting.p.x() > 0.09 && std::abs(sighting.p.y()) < half_gap - 0.005 ? 1 : 0;
    }
    EXPECT_EQ(inside > 0, half_gap < 0.025) << half_gap;
  }
}

TEST(SurroundingsTest, ReachEndsWhatIsSeen) {
  EXPECT_TRUE(Look(HallExperiment(), GroundState{1.5, 0.5, 0}, 0.2).empty());
}

}  // namespace
}  // namespace cairn::actors
