#include "learner/algorithms/sac.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "common/core/check.h"
#include "tests/learner/algorithms/gradient_check.h"
#include "tests/learner/algorithms/update_fixture.h"

namespace cairn::learner {
namespace {

class SacGradientTest : public testing::TestWithParam<bool> {
 protected:
  SacGradientTest() : config_(SmallConfig()), shape_(), sac_(), batch_(1, 1, 1) {
    config_.layer_norm = GetParam();
    shape_ = SmallShape(config_, PolicyShape::Head::kGaussian);
    sac_ = std::make_unique<Sac<double>>(config_, shape_, 1);
    batch_ = MakeBatch<double>(config_, shape_);
    // A few updates make critics and targets differ.
    for (uint32_t i = 1; i <= 5; ++i) {
      FillBatch(i, &batch_);
      sac_->Update(&batch_, 1e-2, Complete());
    }
    FillBatch(0, &batch_);
  }

  LearnerConfig config_;
  PolicyShape shape_;
  std::unique_ptr<Sac<double>> sac_;
  Batch<double> batch_;
};

TEST_P(SacGradientTest, CriticLoss) {
  const Mlp<double>& mlp = sac_->critics().mlp();
  for (int i = 0; i < 2; ++i) {
    TrainedMlp<double>& critic = sac_->critics().critic(i);
    sac_->CriticLoss(&batch_, Complete());
    mlp.FinishGradient(&critic.gradient);
    const std::vector<double> gradient(critic.finished_gradient().begin(), critic.finished_gradient().end());
    ExpectGradient(
        {critic.weights.values.data(), critic.weights.values.size()}, gradient,
        [&] { return sac_->CriticLoss(&batch_, Complete()); }, [&] { mlp.RefreshTransposed(&critic.weights); });
  }
}

TEST_P(SacGradientTest, ActorLoss) {
  const Mlp<double>& mlp = sac_->policy_mlp();
  TrainedMlp<double>& policy = sac_->policy();
  sac_->ActorLoss(&batch_);
  mlp.FinishGradient(&policy.gradient);
  const std::vector<double> gradient(policy.finished_gradient().begin(), policy.finished_gradient().end());
  ExpectGradient(
      {policy.weights.values.data(), policy.weights.values.size()}, gradient, [&] { return sac_->ActorLoss(&batch_); },
      [&] { mlp.RefreshTransposed(&policy.weights); });
}

TEST_P(SacGradientTest, AlphaLoss) {
  sac_->ActorLoss(&batch_);
  const double log_alpha = sac_->log_alpha(), step = 1e-5;
  sac_->SetLogAlpha(log_alpha + step);
  const double above = sac_->AlphaLoss();
  sac_->SetLogAlpha(log_alpha - step);
  const double below = sac_->AlphaLoss();
  EXPECT_NEAR(sac_->AlphaGradient(), (above - below) / (2 * step), 1e-8);
}

INSTANTIATE_TEST_SUITE_P(LayerNorm, SacGradientTest, testing::Bool());

// What the passes over chunks compute, one sample at a time from the formulas.
TEST(SacTest, LossesAreThoseOfThePaper) {
  const LearnerConfig config = SmallConfig();
  const PolicyShape shape = SmallShape(config, PolicyShape::Head::kGaussian);
  Sac<double> sac(config, shape, 1);
  Batch<double> batch = MakeBatch<double>(config, shape);
  const int size = batch.size(), actions = shape.action_size;
  const Mlp<double> policy_mlp({4, config.net_arch, 6, false}, 4, {1});
  const Mlp<double> critic_mlp({7, config.net_arch, 1, false}, 7, {1});
  MlpTape<double> policy_tape(policy_mlp.shape(), 1), critic_tape(critic_mlp.shape(), 1);

  const auto sample = [&](const double* observation, const double* noise, double* input) {
    std::copy_n(observation, 4, input);
    const double* y = policy_mlp.Forward(sac.policy().weights, observation, 1, &policy_tape);
    double log_prob = 0;
    for (int a = 0; a < actions; ++a) {
      const double log_std = std::clamp(y[actions + a], -20.0, 2.0), e = noise[a * size];
      const double action = std::tanh(y[a] + std::exp(log_std) * e);
      log_prob += -0.5 * e * e - log_std - 0.5 * std::log(2 * M_PI) - std::log(1 - action * action);
      input[4 + a] = action;
    }
    return log_prob;
  };
  const auto q_of = [&](const MlpWeights<double>& weights, const double* input) -> double {
    return critic_mlp.Forward(weights, input, 1, &critic_tape)[0];
  };
  double critic_loss = 0, actor_loss = 0;
  for (int j = 0; j < size; ++j) {
    double input[7];
    const double next_log_prob = sample(batch.next_input(j), batch.next_noise() + j, input);
    const double next_q = std::min(q_of(sac.critics().target(0), input), q_of(sac.critics().target(1), input));
    const double y = batch.reward(j) + batch.discount(j) * (next_q - config.initial_alpha * next_log_prob);
    for (int i = 0; i < 2; ++i) {
      const double q = q_of(sac.critics().critic(i).weights, batch.input(j));
      critic_loss += 0.5 * (q - y) * (q - y) / size;
    }
    const double log_prob = sample(batch.input(j), batch.noise() + j, input);
    const double q =
        std::min(q_of(sac.critics().critic(0).weights, input), q_of(sac.critics().critic(1).weights, input));
    actor_loss += (config.initial_alpha * log_prob - q) / size;
  }
  EXPECT_NEAR(sac.CriticLoss(&batch, Complete()), critic_loss, 1e-11);
  EXPECT_NEAR(sac.ActorLoss(&batch), actor_loss, 1e-11);
}

TEST(SacTest, AlphaRisesWhileEntropyIsBelowTarget) {
  LearnerConfig config = SmallConfig();
  const PolicyShape shape = SmallShape(config, PolicyShape::Head::kGaussian);
  for (double target : {-50.0, 50.0}) {
    config.target_entropy = target;
    Sac<float> sac(config, shape, 1);
    Batch<float> batch = MakeBatch<float>(config, shape);
    sac.Update(&batch, 1e-3, Complete());
    EXPECT_EQ(sac.alpha() > config.initial_alpha, target > 0) << target;
  }
}

TEST(SacTest, FixedAlphaStays) {
  LearnerConfig config = SmallConfig();
  config.auto_alpha = false;
  const PolicyShape shape = SmallShape(config, PolicyShape::Head::kGaussian);
  Sac<float> sac(config, shape, 1);
  Batch<float> batch = MakeBatch<float>(config, shape);
  sac.Update(&batch, 1e-3, Complete());
  EXPECT_DOUBLE_EQ(sac.alpha(), config.initial_alpha);
}

TEST(SacTest, FloatFollowsDouble) {
  for (bool layer_norm : {false, true}) {
    LearnerConfig config = SmallConfig();
    config.layer_norm = layer_norm;
    const PolicyShape shape = SmallShape(config, PolicyShape::Head::kGaussian);
    Sac<float> sac(config, shape, 1);
    Sac<double> reference(config, shape, 1);
    Batch<float> batch = MakeBatch<float>(config, shape);
    Batch<double> reference_batch = MakeBatch<double>(config, shape);
    for (uint32_t i = 0; i < 20; ++i) {
      FillBatch(i, &batch);
      FillBatch(i, &reference_batch);
      const UpdateInfo info = sac.Update(&batch, 1e-3, Complete());
      const UpdateInfo expected = reference.Update(&reference_batch, 1e-3, Complete());
      EXPECT_NEAR(info.critic_loss, expected.critic_loss, 1e-4 * std::fabs(expected.critic_loss));
      EXPECT_NEAR(info.actor_loss, expected.actor_loss, 1e-4 * std::fabs(expected.actor_loss));
      EXPECT_NEAR(info.alpha, expected.alpha, 1e-4 * expected.alpha);
    }
    EXPECT_LT(RelativeDistance(sac.policy().parameters(), reference.policy().parameters()), 1e-3);
    EXPECT_LT(RelativeDistance(sac.critics().critic(0).parameters(), reference.critics().critic(0).parameters()), 1e-3);
    EXPECT_LT(RelativeDistance(sac.critics().critic(1).parameters(), reference.critics().critic(1).parameters()), 1e-3);
  }
}

TEST(SacTest, TargetsFollowByTau) {
  LearnerConfig config = SmallConfig();
  config.tau = 0.25;
  const PolicyShape shape = SmallShape(config, PolicyShape::Head::kGaussian);
  Sac<double> sac(config, shape, 1);
  const MlpWeights<double>& target = sac.critics().target(1);
  const std::vector<double> before(target.values.begin(), target.values.end());
  Batch<double> batch = MakeBatch<double>(config, shape);
  sac.Update(&batch, 1e-2, Complete());
  const std::span<const double> online = sac.critics().critic(1).parameters();
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(target.values[i], 0.75 * before[i] + 0.25 * online[i], 1e-14);
  }
}

TEST(SacTest, NonFiniteRewardIsNamedAndChangesNothing) {
  const LearnerConfig config = SmallConfig();
  const PolicyShape shape = SmallShape(config, PolicyShape::Head::kGaussian);
  Sac<float> sac(config, shape, 1);
  Batch<float> batch = MakeBatch<float>(config, shape);
  batch.reward(100) = std::numeric_limits<float>::infinity();
  const std::vector<float> before(sac.critics().critic(0).parameters().begin(),
                                  sac.critics().critic(0).parameters().end());
  try {
    sac.Update(&batch, 1e-3, Complete());
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("critic_loss"));
  }
  EXPECT_EQ(std::memcmp(before.data(), sac.critics().critic(0).parameters().data(), before.size() * sizeof(float)), 0);
}

TEST(SacTest, ClippedGradientTakesASmallerFirstMomentOnly) {
  // Adam's first step does not depend on the gradient's length, the second does.
  LearnerConfig config = SmallConfig();
  const PolicyShape shape = SmallShape(config, PolicyShape::Head::kGaussian);
  Batch<double> batch = MakeBatch<double>(config, shape);
  Sac<double> plain(config, shape, 1);
  config.max_grad_norm = 1e-3;
  Sac<double> clipped(config, shape, 1);
  for (uint32_t i = 0; i < 2; ++i) {
    FillBatch(i, &batch);
    batch.reward(0) = i == 0 ? 1000.0 : 0.0;
    plain.Update(&batch, 1e-3, Complete());
    FillBatch(i, &batch);
    batch.reward(0) = i == 0 ? 1000.0 : 0.0;
    clipped.Update(&batch, 1e-3, Complete());
  }
  EXPECT_GT(RelativeDistance(clipped.critics().critic(0).parameters(), plain.critics().critic(0).parameters()), 1e-5);
}

}  // namespace
}  // namespace cairn::learner
