#include "learner/algorithms/algorithm.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "common/core/check.h"
#include "common/core/random.h"
#include "tests/learner/algorithms/pendulum_run.h"

namespace cairn::learner {
namespace {

Segment RandomSegment(int steps, uint32_t index) {
  RandomStream random(21, RandomPurpose::kTest, index);
  Segment segment;
  segment.end = SegmentEnd::kTerminated;
  segment.observations.resize(static_cast<size_t>(steps + 1) * Pendulum::kObservationSize);
  segment.actions.resize(steps);
  segment.rewards.resize(steps);
  for (auto* values : {&segment.observations, &segment.actions, &segment.rewards}) {
    for (float& v : *values) v = static_cast<float>(random.Uniform(-1.0, 1.0));
  }
  return segment;
}

class AlgorithmTest : public testing::TestWithParam<LearnerConfig::Algorithm> {
 protected:
  AlgorithmTest() : replay_(2000, Pendulum::kObservationSize, Pendulum::kActionSize, 1, 0.99) {
    config_.algorithm = GetParam();
    config_.target_entropy = -1;
    config_.batch_size = 200;
    replay_.Insert(RandomSegment(1500, 0));
  }

  std::unique_ptr<Algorithm> Make(uint64_t seed) { return MakeAlgorithm(config_, PendulumShape(config_), seed); }

  LearnerConfig config_;
  ReplayBuffer replay_;
};

TEST_P(AlgorithmTest, GoesOnFromItsStateWithTheSameBits) {
  const auto a = Make(1), b = Make(1);
  a->Update(replay_, 17, 0.0);
  b->Load(a->Save());
  EXPECT_EQ(a->WeightsCrc32c(), b->WeightsCrc32c());
  a->Update(replay_, 13, 0.5);
  b->Update(replay_, 13, 0.5);
  EXPECT_EQ(a->WeightsCrc32c(), b->WeightsCrc32c());
  EXPECT_EQ(b->TakeInfo().num_updates, 30);
}

TEST_P(AlgorithmTest, TakesNetworksAloneFromAnotherRun) {
  const auto a = Make(1), b = Make(1);
  a->Update(replay_, 17, 0.0);
  b->LoadNetworks(a->Save());
  EXPECT_EQ(a->WeightsCrc32c(), b->WeightsCrc32c());
  EXPECT_EQ(b->TakeInfo().num_updates, 0);
}

TEST_P(AlgorithmTest, NetworksThatComeBackHaveFreshOptimizers) {
  const auto a = Make(1);
  const std::vector<StateArray> start = a->Save();
  a->Update(replay_, 10, 0.0);
  a->LoadNetworks(start);
  int moments = 0;
  for (const StateArray& array : a->Save()) {
    if (array.name.find(".adam.") == std::string::npos) continue;
    ++moments;
    EXPECT_EQ(array.data, Bytes(array.data.size(), 0)) << array.name;
  }
  EXPECT_GE(moments, 9) << "of the policy and both critics";
  EXPECT_EQ(a->TakeInfo().num_updates, 10) << "random numbers do not begin again";
}

TEST_P(AlgorithmTest, RefusesAStateOfAnotherShapeAndStaysAsItWas) {
  const auto a = Make(1);
  const uint32_t before = a->WeightsCrc32c();
  LearnerConfig other = config_;
  other.net_arch = {32, 64};
  EXPECT_THROW(a->Load(MakeAlgorithm(other, PendulumShape(other), 1)->Save()), Error);
  std::vector<StateArray> state = Make(2)->Save();
  state.pop_back();
  EXPECT_THROW(a->Load(state), Error);
  EXPECT_EQ(a->WeightsCrc32c(), before);
}

TEST_P(AlgorithmTest, SameSeedSameBits) {
  const auto a = Make(1), b = Make(1), c = Make(2);
  EXPECT_EQ(a->WeightsCrc32c(), b->WeightsCrc32c());
  EXPECT_NE(a->WeightsCrc32c(), c->WeightsCrc32c());
  a->Update(replay_, 30, 0.0);
  for (int i = 0; i < 3; ++i) b->Update(replay_, 10, 0.0);  // nor does it matter how updates are grouped
  EXPECT_EQ(a->WeightsCrc32c(), b->WeightsCrc32c());
  EXPECT_EQ(
      std::memcmp(a->policy_parameters().data(), b->policy_parameters().data(), a->policy_parameters().size_bytes()),
      0);
}

TEST_P(AlgorithmTest, ThreadsShareAnUpdateWithoutChance) {
  config_.batch_size = 700;  // six chunks
  const auto alone = Make(1);
  alone->Update(replay_, 20, 0.0);
  const std::span<const float> expected = alone->policy_parameters();
  for (int threads : {2, 3, 4, 64}) {
    config_.update_threads = threads;
    const auto a = Make(1), b = Make(1);
    a->Update(replay_, 20, 0.0);
    b->Update(replay_, 20, 0.0);
    EXPECT_EQ(a->WeightsCrc32c(), b->WeightsCrc32c()) << threads;
    EXPECT_NEAR(a->TakeInfo().critic_loss, b->TakeInfo().critic_loss, 0.0);
    double difference = 0, norm = 0;
    for (size_t i = 0; i < expected.size(); ++i) {
      const double d = a->policy_parameters()[i] - expected[i];
      difference += d * d;
      norm += double{expected[i]} * expected[i];
    }
    EXPECT_LT(std::sqrt(difference / norm), 1e-4) << threads;
  }
}

TEST_P(AlgorithmTest, WeightsCrcSeesEveryUpdate) {
  const auto algorithm = Make(1);
  const uint32_t before = algorithm->WeightsCrc32c();
  algorithm->Update(replay_, 1, 0.0);
  EXPECT_NE(algorithm->WeightsCrc32c(), before);
}

TEST_P(AlgorithmTest, InfoIsTheMeanSinceTheLastCall) {
  const auto whole = Make(1), parts = Make(1);
  whole->Update(replay_, 4, 0.0);
  const UpdateInfo mean = whole->TakeInfo();
  parts->Update(replay_, 2, 0.0);
  const UpdateInfo first = parts->TakeInfo();
  parts->Update(replay_, 2, 0.0);
  const UpdateInfo second = parts->TakeInfo();
  EXPECT_EQ(mean.num_updates, 4);
  EXPECT_EQ(second.num_updates, 4);
  EXPECT_NEAR(mean.critic_loss, 0.5 * (first.critic_loss + second.critic_loss), 1e-12);
  EXPECT_NEAR(mean.actor_loss, 0.5 * (first.actor_loss + second.actor_loss), 1e-12);
  EXPECT_EQ(mean.num_actor_updates, first.num_actor_updates + second.num_actor_updates);
}

TEST_P(AlgorithmTest, LearningRateDecaysWithProgress) {
  config_.final_learning_rate_fraction = 0.0;
  const auto at_end = Make(1);
  const std::vector<float> before(at_end->policy_parameters().begin(), at_end->policy_parameters().end());
  at_end->Update(replay_, 4, 1.0);
  EXPECT_EQ(std::memcmp(before.data(), at_end->policy_parameters().data(), before.size() * sizeof(float)), 0);
  at_end->Update(replay_, 4, 0.5);
  EXPECT_NE(std::memcmp(before.data(), at_end->policy_parameters().data(), before.size() * sizeof(float)), 0);
}

TEST_P(AlgorithmTest, BadUpdatesAreLeftOutAndTooManyInARowStopWithTheLossNamed) {
  Segment segment = RandomSegment(2000, 1);
  for (float& reward : segment.rewards) reward = std::numeric_limits<float>::quiet_NaN();
  ReplayBuffer bad(2000, Pendulum::kObservationSize, Pendulum::kActionSize, 1, 0.99);
  bad.Insert(segment);
  config_.max_bad_updates = 4;
  const auto algorithm = Make(1);
  algorithm->Update(replay_, 5, 0.0);
  const uint32_t weights = algorithm->WeightsCrc32c();
  algorithm->Update(bad, 3, 0.0);
  EXPECT_EQ(algorithm->WeightsCrc32c(), weights);
  const UpdateInfo info = algorithm->TakeInfo();
  EXPECT_EQ(info.bad_updates, 3);
  EXPECT_EQ(info.num_means, 5);
  EXPECT_EQ(algorithm->TakeInfo().num_means, 0);
  const auto resumed = Make(1);
  resumed->Load(algorithm->Save());
  EXPECT_EQ(resumed->TakeInfo().bad_updates, 3) << "a run that goes on goes on counting";
  algorithm->Update(replay_, 2, 0.0);  // in between one that is sound
  EXPECT_NE(algorithm->WeightsCrc32c(), weights);
  algorithm->Update(bad, 3, 0.0);
  try {
    algorithm->Update(bad, 1, 0.0);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("4 updates in a row"));
    EXPECT_THAT(error.what(), testing::HasSubstr("critic_loss"));
  }
}

INSTANTIATE_TEST_SUITE_P(SacAndTd3, AlgorithmTest,
                         testing::Values(LearnerConfig::Algorithm::kSac, LearnerConfig::Algorithm::kTd3),
                         [](const auto& test) { return test.param == LearnerConfig::Algorithm::kSac ? "Sac" : "Td3"; });

TEST(PendulumTest, SacSwingsUpWithinTenThousandSteps) {
  PendulumRun run(PendulumSacConfig(), 1);
  EXPECT_LT(run.MeanReturn(20), -800.0) << "not solved by chance";
  run.Train(10000);
  const double mean_return = run.MeanReturn(20);
  RecordProperty("mean_return", std::to_string(mean_return));
  EXPECT_GE(mean_return, -200.0);
}

TEST(PendulumTest, Td3SwingsUpToo) {
  LearnerConfig config;
  config.algorithm = LearnerConfig::Algorithm::kTd3;
  config.batch_size = 100;
  config.buffer_size = 10000;
  config.learning_starts = 1000;
  config.n_steps = 1;
  PendulumRun run(config, 1);
  run.Train(10000);
  EXPECT_GE(run.MeanReturn(20), -250.0);
}

}  // namespace
}  // namespace cairn::learner
