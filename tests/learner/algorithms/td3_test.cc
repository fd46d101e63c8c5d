#include "learner/algorithms/td3.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include "common/core/check.h"
#include "tests/learner/algorithms/gradient_check.h"
#include "tests/learner/algorithms/update_fixture.h"

namespace cairn::learner {
namespace {

class Td3GradientTest : public testing::TestWithParam<bool> {
 protected:
  Td3GradientTest() : config_(SmallConfig()), batch_(1, 1, 1) {
    config_.layer_norm = GetParam();
    const PolicyShape shape = SmallShape(config_, PolicyShape::Head::kDeterministic);
    td3_ = std::make_unique<Td3<double>>(config_, shape, 1);
    batch_ = MakeBatch<double>(config_, shape);
    for (uint32_t i = 1; i <= 5; ++i) {
      FillBatch(i, &batch_);
      td3_->Update(&batch_, 1e-2, Complete());
    }
    FillBatch(0, &batch_);
  }

  LearnerConfig config_;
  std::unique_ptr<Td3<double>> td3_;
  Batch<double> batch_;
};

TEST_P(Td3GradientTest, CriticLoss) {
  const Mlp<double>& mlp = td3_->critics().mlp();
  TrainedMlp<double>& critic = td3_->critics().critic(1);
  td3_->CriticLoss(&batch_, Complete());
  mlp.FinishGradient(&critic.gradient);
  const std::vector<double> gradient(critic.finished_gradient().begin(), critic.finished_gradient().end());
  ExpectGradient(
      {critic.weights.values.data(), critic.weights.values.size()}, gradient,
      [&] { return td3_->CriticLoss(&batch_, Complete()); }, [&] { mlp.RefreshTransposed(&critic.weights); });
}

TEST_P(Td3GradientTest, ActorLoss) {
  const Mlp<double>& mlp = td3_->policy_mlp();
  TrainedMlp<double>& policy = td3_->policy();
  td3_->ActorLoss(&batch_);
  mlp.FinishGradient(&policy.gradient);
  const std::vector<double> gradient(policy.finished_gradient().begin(), policy.finished_gradient().end());
  ExpectGradient(
      {policy.weights.values.data(), policy.weights.values.size()}, gradient, [&] { return td3_->ActorLoss(&batch_); },
      [&] { mlp.RefreshTransposed(&policy.weights); });
}

INSTANTIATE_TEST_SUITE_P(LayerNorm, Td3GradientTest, testing::Bool());

TEST(Td3Test, LossesAreThoseOfThePaper) {
  const LearnerConfig config = SmallConfig();
  const PolicyShape shape = SmallShape(config, PolicyShape::Head::kDeterministic);
  Td3<double> td3(config, shape, 1);
  Batch<double> batch = MakeBatch<double>(config, shape);
  const int size = batch.size();
  const Mlp<double> policy_mlp({4, config.net_arch, 3, false}, 4, {1});
  const Mlp<double> critic_mlp({7, config.net_arch, 1, false}, 7, {1});
  MlpTape<double> policy_tape(policy_mlp.shape(), 1), critic_tape(critic_mlp.shape(), 1);
  const auto q_of = [&](const MlpWeights<double>& weights, const double* input) -> double {
    return critic_mlp.Forward(weights, input, 1, &critic_tape)[0];
  };
  double critic_loss = 0, actor_loss = 0;
  for (int j = 0; j < size; ++j) {
    double input[7];
    std::copy_n(batch.next_input(j), 4, input);
    const double* next = policy_mlp.Forward(td3.policy_target(), input, 1, &policy_tape);
    for (int a = 0; a < 3; ++a) {
      const double noise = std::clamp(config.target_policy_noise * batch.next_noise()[a * size + j],
                                      -config.target_noise_clip, config.target_noise_clip);
      input[4 + a] = std::clamp(std::tanh(next[a]) + noise, -1.0, 1.0);
    }
    const double next_q = std::min(q_of(td3.critics().target(0), input), q_of(td3.critics().target(1), input));
    const double y = batch.reward(j) + batch.discount(j) * next_q;
    for (int i = 0; i < 2; ++i) {
      const double q = q_of(td3.critics().critic(i).weights, batch.input(j));
      critic_loss += (q - y) * (q - y) / size;
    }
    std::copy_n(batch.input(j), 4, input);
    const double* action = policy_mlp.Forward(td3.policy().weights, input, 1, &policy_tape);
    for (int a = 0; a < 3; ++a) input[4 + a] = std::tanh(action[a]);
    actor_loss -= q_of(td3.critics().critic(0).weights, input) / size;
  }
  EXPECT_NEAR(td3.CriticLoss(&batch, Complete()), critic_loss, 1e-11);
  EXPECT_NEAR(td3.ActorLoss(&batch), actor_loss, 1e-11);
}

TEST(Td3Test, PolicyAndTargetsWaitForTheirTurn) {
  LearnerConfig config = SmallConfig();
  config.policy_delay = 3;
  const PolicyShape shape = SmallShape(config, PolicyShape::Head::kDeterministic);
  Td3<float> td3(config, shape, 1);
  Batch<float> batch = MakeBatch<float>(config, shape);
  for (int update = 1; update <= 7; ++update) {
    const std::vector<float> policy(td3.policy().parameters().begin(), td3.policy().parameters().end());
    const float target = td3.critics().target(0).values[0], policy_target = td3.policy_target().values[0];
    FillBatch(update, &batch);
    const UpdateInfo info = td3.Update(&batch, 1e-2, Complete());
    const bool turn = update % 3 == 0;
    EXPECT_EQ(info.num_actor_updates, turn ? 1 : 0);
    EXPECT_EQ(std::memcmp(policy.data(), td3.policy().parameters().data(), policy.size() * sizeof(float)) != 0, turn);
    EXPECT_EQ(target != td3.critics().target(0).values[0], turn);
    EXPECT_EQ(policy_target != td3.policy_target().values[0], turn);
  }
}

TEST(Td3Test, FloatFollowsDouble) {
  const LearnerConfig config = SmallConfig();
  const PolicyShape shape = SmallShape(config, PolicyShape::Head::kDeterministic);
  Td3<float> td3(config, shape, 1);
  Td3<double> reference(config, shape, 1);
  Batch<float> batch = MakeBatch<float>(config, shape);
  Batch<double> reference_batch = MakeBatch<double>(config, shape);
  for (uint32_t i = 0; i < 20; ++i) {
    FillBatch(i, &batch);
    FillBatch(i, &reference_batch);
    const UpdateInfo info = td3.Update(&batch, 1e-3, Complete());
    const UpdateInfo expected = reference.Update(&reference_batch, 1e-3, Complete());
    EXPECT_NEAR(info.critic_loss, expected.critic_loss, 1e-4 * std::fabs(expected.critic_loss));
    EXPECT_NEAR(info.actor_loss, expected.actor_loss, 1e-4);
  }
  EXPECT_LT(RelativeDistance(td3.policy().parameters(), reference.policy().parameters()), 1e-3);
  EXPECT_LT(RelativeDistance(td3.critics().critic(0).parameters(), reference.critics().critic(0).parameters()), 1e-3);
}

TEST(Td3Test, NonFiniteObservationIsNamed) {
  const LearnerConfig config = SmallConfig();
  const PolicyShape shape = SmallShape(config, PolicyShape::Head::kDeterministic);
  Td3<float> td3(config, shape, 1);
  Batch<float> batch = MakeBatch<float>(config, shape);
  batch.input(7)[1] = std::numeric_limits<float>::quiet_NaN();
  try {
    td3.Update(&batch, 1e-3, Complete());
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("critic"));
  }
}

}  // namespace
}  // namespace cairn::learner
