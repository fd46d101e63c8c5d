#include "learner/evaluation_queue.h"

#include <gtest/gtest.h>

namespace cairn::learner {
namespace {

EpisodeResult Result(int64_t id, int start, int steps = 7) {
  EpisodeResult r;
  r.set = StartSet::kConsumption;
  r.episode = static_cast<int32_t>(id);
  r.vehicle = start;
  r.steps = steps;
  return r;
}

TEST(EvaluationQueueTest, TakesEveryStartOnceAndIgnoresForeignOnes) {
  EvaluationQueue queue;
  EXPECT_EQ(queue.id(), 0);
  queue.Accept(Result(1, 0));
  queue.Add({.version = 4, .num_starts = 2});
  queue.Accept(Result(1, 0));
  queue.Accept(Result(1, 0, 99));  // known
  queue.Accept(Result(1, 2));      // no such start
  queue.Accept(Result(1, -1));
  queue.Accept(Result(2, 1));  // another evaluation's
  EXPECT_TRUE(queue.TakeReports().empty());
  queue.Accept(Result(1, 1, 9));
  const auto reports = queue.TakeReports();
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_EQ(reports[0].request.version, 4);
  EXPECT_EQ(reports[0].results[0].steps, 7);
  EXPECT_EQ(reports[0].results[1].steps, 9);
  EXPECT_TRUE(queue.empty());
}

TEST(EvaluationQueueTest, RunsOneAfterTheOtherAndKeepsTheirPoliciesInUse) {
  EvaluationQueue queue;
  queue.Add({.version = 4, .num_starts = 1});
  queue.Add({.version = 5, .num_starts = 1});
  EXPECT_EQ(queue.running().version, 4);
  EXPECT_TRUE(queue.Uses(5));
  queue.Accept(Result(1, 0));
  EXPECT_FALSE(queue.Uses(4));
  EXPECT_EQ(queue.id(), 2);
  EXPECT_EQ(queue.running().version, 5);
}

TEST(EvaluationQueueTest, ARestartForgetsResultsAndTakesAFreshId) {
  EvaluationQueue queue;
  queue.Restart();
  EXPECT_EQ(queue.id(), 0);
  queue.Add({.num_starts = 2});
  queue.Accept(Result(1, 0));
  queue.Restart();
  EXPECT_EQ(queue.id(), 2);
  queue.Accept(Result(1, 1));
  queue.Accept(Result(2, 1));
  EXPECT_TRUE(queue.TakeReports().empty());
}

TEST(EvaluationQueueTest, SharesCoverEveryStartOnce) {
  EvaluationQueue queue;
  EXPECT_EQ(queue.Share(0, 3), std::make_pair(0, 0));
  queue.Add({.num_starts = 10});
  int next = 0;
  for (int rank = 0; rank < 3; ++rank) {
    const auto [first, end] = queue.Share(rank, 3);
    EXPECT_EQ(first, next);
    next = end;
  }
  EXPECT_EQ(next, 10);
}

}  // namespace
}  // namespace cairn::learner
