#include "common/rl/summary.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace cairn {
namespace {

EpisodeResult Result(Outcome outcome, float duration = 0, float path = 0, float shortest = 0) {
  EpisodeResult result;
  result.outcome = outcome;
  result.duration = duration;
  result.path_length = path;
  result.shortest_length = shortest;
  result.steps = 10;
  result.min_clearance = outcome == Outcome::kCollision ? 0.0f : 0.02f;
  result.mean_jerk = 4;
  result.episode_return = 2;
  return result;
}

// Wilson 1927; 8 of 10 at 95 %: the values of R's prop.test(correct = FALSE).
TEST(WilsonIntervalTest, KnownValues) {
  EXPECT_NEAR(WilsonInterval(8, 10).low, 0.4901625, 1e-6);
  EXPECT_NEAR(WilsonInterval(8, 10).high, 0.9433178, 1e-6);
  EXPECT_DOUBLE_EQ(WilsonInterval(200, 200).high, 1);
  EXPECT_NEAR(WilsonInterval(200, 200).low, 0.981155, 1e-5);
  EXPECT_NEAR(WilsonInterval(0, 200).low, 0, 1e-15);
  EXPECT_NEAR(WilsonInterval(0, 200).high, 1 - 0.981155, 1e-5);
}

TEST(WilsonIntervalTest, KnowsNothingWithoutTrials) {
  EXPECT_EQ(WilsonInterval(0, 0).low, 0);
  EXPECT_EQ(WilsonInterval(0, 0).high, 1);
}

TEST(SummariseTest, CountsOutcomesAndAverages) {
  const std::vector<EpisodeResult> results{Result(Outcome::kGoal, 10, 5, 4), Result(Outcome::kGoal, 20, 4, 4),
                                           Result(Outcome::kCollision, 3, 9, 4), Result(Outcome::kTimeout, 60, 30, 4),
                                           Result(Outcome::kDiverged)};
  const EvaluationSummary summary = Summarise(results);
  EXPECT_EQ(summary.trials, 5);
  EXPECT_EQ(summary.successes, 2);
  EXPECT_EQ(summary.collisions, 1);
  EXPECT_EQ(summary.timeouts, 1);
  EXPECT_EQ(summary.diverged, 1);
  EXPECT_EQ(summary.steps, 50);
  EXPECT_DOUBLE_EQ(summary.success_rate, 0.4);
  EXPECT_DOUBLE_EQ(summary.mean_time_to_goal, 15);
  EXPECT_DOUBLE_EQ(summary.mean_path_length, 4.5);
  EXPECT_DOUBLE_EQ(summary.spl, (0.8 + 1.0) / 5);
  EXPECT_EQ(summary.min_clearance, 0);
  EXPECT_NEAR(summary.mean_clearance, 0.016, 1e-7);
  EXPECT_DOUBLE_EQ(summary.mean_jerk, 4);
  EXPECT_DOUBLE_EQ(summary.mean_return, 2);
  EXPECT_NEAR(summary.success_interval.low, WilsonInterval(2, 5).low, 1e-12);
}

TEST(SummariseTest, ShorterThanTheRoadmapOrUnknownCountsFull) {
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(Summarise(std::vector{Result(Outcome::kGoal, 1, 3, 4)}).spl, 1);
  EXPECT_EQ(Summarise(std::vector{Result(Outcome::kGoal, 1, 3, infinity)}).spl, 1);
}

TEST(SummariseTest, NothingIsNothing) {
  const EvaluationSummary summary = Summarise({});
  EXPECT_EQ(summary.trials, 0);
  EXPECT_EQ(summary.success_rate, 0);
  EXPECT_EQ(summary.min_clearance, 0);
}

TEST(SummariseTest, PrintsOneLine) {
  const std::string line = ToString(Summarise(std::vector{Result(Outcome::kGoal, 10, 5, 4)}));
  EXPECT_NE(line.find("1/1 solved"), std::string::npos);
  EXPECT_NE(line.find("SPL 0.800"), std::string::npos);
}

}  // namespace
}  // namespace cairn
