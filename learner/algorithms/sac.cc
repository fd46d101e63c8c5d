#include "learner/algorithms/sac.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/check.h"
#include "common/nn/layers.h"
#include "learner/algorithms/shapes.h"

namespace cairn::learner {

using cairn::layers::LaneSum;

template <typename Scalar>
Sac<Scalar>::Sac(const LearnerConfig& config, const PolicyShape& shape, uint64_t seed)
    : config_(config),
      action_size_(shape.action_size),
      chunks_(config.batch_size, config.update_threads, CriticMlpShape(shape).num_parameters()),
      policy_mlp_(PolicyMlpShape(shape), BatchStride(shape.observation_size, shape.action_size), chunks_.sizes()),
      policy_(policy_mlp_, seed, 0),
      critics_(CriticMlpShape(shape), BatchStride(shape.observation_size, shape.action_size), chunks_.sizes(),
               shape.action_size, seed),
      log_alpha_(std::log(config.initial_alpha)),
      alpha_adam_(1),
      team_(chunks_.num_shares()) {
  CAIRN_CHECK(shape.head == PolicyShape::Head::kGaussian && policy_.weights.values.size() == shape.num_parameters());
  for (int share = 0; share < team_.size(); ++share) works_.push_back(MakeWork(share));
}

template <typename Scalar>
typename Sac<Scalar>::Work Sac<Scalar>::MakeWork(int share) const {
  TanhGaussian<Scalar> head(action_size_, policy_mlp_.max_columns());
  const auto samples = static_cast<size_t>(head.stride());
  return {MlpTape<Scalar>(policy_mlp_.shape(), policy_mlp_.max_columns()),
          share > 0 ? policy_mlp_.MakeGradientBuffer() : AlignedBuffer<Scalar>(),
          critics_.MakeWork(share),
          std::move(head),
          AlignedBuffer<Scalar>(samples),
          AlignedBuffer<Scalar>(samples * action_size_)};
}

template <typename Scalar>
double Sac<Scalar>::alpha() const {
  return std::exp(log_alpha_);
}

template <typename Scalar>
UpdateInfo Sac<Scalar>::Update(Batch<Scalar>* batch, double learning_rate, BatchFeeder* feeder) {
  UpdateInfo info;
  info.critic_loss = CriticLoss(batch, feeder);
  CheckFinite(info.critic_loss, "critic_loss");
  critics_.Step(learning_rate, config_.max_grad_norm);

  info.actor_loss = ActorLoss(batch);
  CheckFinite(info.actor_loss, "actor_loss");
  TrainedMlp<Scalar>* const policy[] = {&policy_};
  ApplyGradients<Scalar>(policy_mlp_, policy, learning_rate, config_.max_grad_norm, "policy");

  info.alpha = alpha();
  info.alpha_loss = AlphaLoss();
  if (config_.auto_alpha) {
    const double gradient = AlphaGradient();
    alpha_adam_.Step(learning_rate, {&gradient, 1}, 1.0, {&log_alpha_, 1});
  }
  critics_.UpdateTargets(config_.tau);

  info.mean_q = works_[0].critics.q / (2.0 * batch->size());
  info.mean_log_prob = mean_log_prob_;
  info.num_actor_updates = 1;
  return info;
}

template <typename Scalar>
double Sac<Scalar>::CriticLoss(Batch<Scalar>* batch, BatchFeeder* feeder) {
  ForChunks(&team_, chunks_, feeder, &works_, [&](int first, int n, Accumulate accumulate, Work* work) {
    CriticChunk(batch, first, n, accumulate, work);
  });
  auto& sum = works_[0].critics;
  for (size_t t = 1; t < works_.size(); ++t) critics_.AddRegression(works_[t].critics, &sum);
  return 0.5 * sum.squared_error / batch->size();
}

template <typename Scalar>
void Sac<Scalar>::CriticChunk(Batch<Scalar>* batch, int first, int n, Accumulate accumulate, Work* work) {
  // a' ~ π(·|s')
  const Scalar* y = policy_mlp_.Value(policy_.weights, batch->next_input(first), n, &work->policy_tape);
  work->head.Sample(y, n, batch->next_noise() + first, batch->size(), batch->next_action(first), batch->stride());
  const Scalar* log_prob = work->head.log_prob();
  // y = R + discount (min_i Q'_i(s', a') − alpha log π(a'|s'))
  Scalar* target_q = work->q.data();
  critics_.MinTargetQ(batch->next_input(first), n, &work->critics, target_q);
  const auto entropy_weight = static_cast<Scalar>(alpha());
  for (int j = 0; j < n; ++j) {
    target_q[j] = batch->reward(first + j) + batch->discount(first + j) * (target_q[j] - entropy_weight * log_prob[j]);
  }
  // J_Q = ½ mean (Q_i(s, a) − y)²
  critics_.Regress(batch->input(first), target_q, n, Scalar{1} / static_cast<Scalar>(batch->size()), accumulate,
                   &work->critics);
}

template <typename Scalar>
double Sac<Scalar>::ActorLoss(Batch<Scalar>* batch) {
  for (Work& work : works_) work.actor_loss = work.log_prob = 0;
  BatchFeeder complete;
  ForChunks(&team_, chunks_, &complete, &works_, [&](int first, int n, Accumulate accumulate, Work* work) {
    ActorChunk(batch, first, n, accumulate, work);
  });
  Work& sum = works_[0];
  for (size_t t = 1; t < works_.size(); ++t) {
    AddGradient(works_[t].policy_gradient, &policy_.gradient);
    sum.actor_loss += works_[t].actor_loss;
    sum.log_prob += works_[t].log_prob;
  }
  mean_log_prob_ = sum.log_prob / batch->size();
  return sum.actor_loss / batch->size();
}

template <typename Scalar>
void Sac<Scalar>::ActorChunk(Batch<Scalar>* batch, int first, int n, Accumulate accumulate, Work* work) {
  policy_mlp_.LossGradient(policy_.weights, batch->input(first), n, accumulate, &work->policy_tape,
                           GradientOf(&policy_, &work->policy_gradient),
                           [&](int offset, int count, const Scalar* y, Scalar* d_y) {
                             ActorBlock(batch, first + offset, count, y, d_y, work);
                           });
}

// J_π = mean (alpha log π(a|s) − min_i Q_i(s, a)); a ~ π(·|s), reparameterised, takes the place of the stored action.
template <typename Scalar>
void Sac<Scalar>::ActorBlock(Batch<Scalar>* batch, int first, int n, const Scalar* y, Scalar* d_y, Work* work) {
  work->head.Sample(y, n, batch->noise() + first, batch->size(), batch->action(first), batch->stride());
  const Scalar* log_prob = work->head.log_prob();
  critics_.MinQ(batch->input(first), n, &work->critics, work->q.data());
  const double entropy_weight = alpha();
  const double sum_log_prob = LaneSum<double>(n, [=](int j) { return static_cast<double>(log_prob[j]); });
  work->log_prob += sum_log_prob;
  const Scalar* q = work->q.data();
  work->actor_loss +=
      entropy_weight * sum_log_prob - LaneSum<double>(n, [q](int j) { return static_cast<double>(q[j]); });
  critics_.ActionGradient(&work->critics, work->d_action.data(), work->head.stride());
  work->head.Backward(work->d_action.data(), n, static_cast<Scalar>(entropy_weight),
                      Scalar{1} / static_cast<Scalar>(batch->size()), d_y);
}

template <typename Scalar>
double Sac<Scalar>::AlphaLoss() const {
  return -log_alpha_ * (mean_log_prob_ + config_.target_entropy);
}

template <typename Scalar>
double Sac<Scalar>::AlphaGradient() const {
  return -(mean_log_prob_ + config_.target_entropy);
}

template <typename Scalar>
void Sac<Scalar>::VisitWeights(const std::function<void(std::string_view, std::span<const Scalar>)>& visit) const {
  const auto log_alpha = static_cast<Scalar>(log_alpha_);
  visit("policy", policy_.parameters());
  critics_.VisitWeights(visit);
  visit("log_alpha", {&log_alpha, 1});
}

template <typename Scalar>
void Sac<Scalar>::VisitState(const StateVisitor& visit) {
  policy_.VisitState("policy", visit);
  critics_.VisitState(visit);
  VisitNumbers(visit, "log_alpha", true, &log_alpha_, 1);
  alpha_adam_.VisitState("log_alpha.adam", visit);
}

template <typename Scalar>
void Sac<Scalar>::StateChanged() {
  policy_mlp_.RefreshTransposed(&policy_.weights);
  critics_.StateChanged();
}

template <typename Scalar>
void Sac<Scalar>::ResetOptimizers() {
  policy_.adam.Reset();
  critics_.ResetOptimizers();
  alpha_adam_.Reset();
}

template class Sac<float>;
template class Sac<double>;

}  // namespace cairn::learner
