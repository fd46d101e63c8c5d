#include "learner/algorithms/td3.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"
#include "common/nn/full_width.h"
#include "common/nn/layers.h"
#include "common/nn/vector_math.h"
#include "learner/algorithms/shapes.h"

namespace cairn::learner {
namespace {

template <typename Scalar>
Scalar Clip(Scalar x, Scalar limit) {
  const Scalar above = x < -limit ? -limit : x;  // one comparison after the other: a maximum and a minimum
  return limit < above ? limit : above;
}

template <typename Scalar>
void Tanh(const Scalar* from, int n, Scalar* to) {
  AtFullWidth([=]() CAIRN_INLINE_LOOP {
    for (int i = 0; i < n; ++i) to[i] = math::Tanh(from[i]);
  });
}

}  // namespace

template <typename Scalar>
Td3<Scalar>::Td3(const LearnerConfig& config, const PolicyShape& shape, uint64_t seed)
    : config_(config),
      action_size_(shape.action_size),
      chunks_(config.batch_size, config.update_threads, CriticMlpShape(shape).num_parameters()),
      policy_mlp_(PolicyMlpShape(shape), BatchStride(shape.observation_size, shape.action_size), chunks_.sizes()),
      policy_(policy_mlp_, seed, 0),
      policy_target_(CopyWeights(policy_mlp_, policy_.weights)),
      critics_(CriticMlpShape(shape), BatchStride(shape.observation_size, shape.action_size), chunks_.sizes(),
               shape.action_size, seed),
      team_(chunks_.num_shares()) {
  CAIRN_CHECK(shape.head == PolicyShape::Head::kDeterministic &&
              policy_.weights.values.size() == shape.num_parameters());
  for (int share = 0; share < team_.size(); ++share) works_.push_back(MakeWork(share));
}

template <typename Scalar>
typename Td3<Scalar>::Work Td3<Scalar>::MakeWork(int share) const {
  const int stride = (policy_mlp_.max_columns() + 15) / 16 * 16;
  const auto samples = static_cast<size_t>(stride);
  return {MlpTape<Scalar>(policy_mlp_.shape(), policy_mlp_.max_columns()),
          share > 0 ? policy_mlp_.MakeGradientBuffer() : AlignedBuffer<Scalar>(),
          critics_.MakeWork(share),
          stride,
          AlignedBuffer<Scalar>(samples),
          AlignedBuffer<Scalar>(samples * action_size_),
          AlignedBuffer<Scalar>(samples * action_size_)};
}

template <typename Scalar>
UpdateInfo Td3<Scalar>::Update(Batch<Scalar>* batch, double learning_rate, BatchFeeder* feeder) {
  UpdateInfo info;
  info.critic_loss = CriticLoss(batch, feeder);
  info.mean_q = works_[0].critics.q / (2.0 * batch->size());
  CheckFinite(info.critic_loss, "critic_loss");
  critics_.Step(learning_rate, config_.max_grad_norm);
  if (++num_updates_ % config_.policy_delay != 0) return info;

  info.actor_loss = ActorLoss(batch);
  CheckFinite(info.actor_loss, "actor_loss");
  TrainedMlp<Scalar>* const policy[] = {&policy_};
  ApplyGradients<Scalar>(policy_mlp_, policy, learning_rate, config_.max_grad_norm, "policy");
  critics_.UpdateTargets(config_.tau);
  Polyak<Scalar>(config_.tau, policy_.parameters(), {policy_target_.values.data(), policy_target_.values.size()});
  policy_mlp_.RefreshHead(&policy_target_);
  info.num_actor_updates = 1;
  return info;
}

template <typename Scalar>
double Td3<Scalar>::CriticLoss(Batch<Scalar>* batch, BatchFeeder* feeder) {
  ForChunks(&team_, chunks_, feeder, &works_, [&](int first, int n, Accumulate accumulate, Work* work) {
    CriticChunk(batch, first, n, accumulate, work);
  });
  auto& sum = works_[0].critics;
  for (size_t t = 1; t < works_.size(); ++t) critics_.AddRegression(works_[t].critics, &sum);
  return sum.squared_error / batch->size();
}

template <typename Scalar>
void Td3<Scalar>::CriticChunk(Batch<Scalar>* batch, int first, int n, Accumulate accumulate, Work* work) {
  SmoothedTargetAction(batch, first, n, work);
  // y = R + discount min_i Q'_i(s', a')
  Scalar* target_q = work->q.data();
  critics_.MinTargetQ(batch->next_input(first), n, &work->critics, target_q);
  for (int j = 0; j < n; ++j) {
    target_q[j] = math::Fma(batch->discount(first + j), target_q[j], batch->reward(first + j));
  }
  // mean (Q_i(s, a) − y)²
  critics_.Regress(batch->input(first), target_q, n, Scalar{2} / static_cast<Scalar>(batch->size()), accumulate,
                   &work->critics);
}

// a' = clip(π'(s') + clip(ε, −c, c), −1, 1), ε ~ N(0, σ)
template <typename Scalar>
void Td3<Scalar>::SmoothedTargetAction(Batch<Scalar>* batch, int first, int n, Work* work) {
  const auto sigma = static_cast<Scalar>(config_.target_policy_noise);
  const auto limit = static_cast<Scalar>(config_.target_noise_clip);
  const Scalar* y = policy_mlp_.Value(policy_target_, batch->next_input(first), n, &work->policy_tape);
  Tanh(y, n * action_size_, work->action.data());
  for (int a = 0; a < action_size_; ++a) {
    const Scalar* from = batch->next_noise() + static_cast<size_t>(a) * batch->size() + first;
    Scalar* to = work->noise.data() + static_cast<size_t>(a) * work->stride;
    AtFullWidth([=]() CAIRN_INLINE_LOOP {
      for (int j = 0; j < n; ++j) to[j] = Clip(sigma * from[j], limit);
    });
  }
  for (int a = 0; a < action_size_; ++a) {
    const Scalar* action = work->action.data() + a;
    const Scalar* noise = work->noise.data() + static_cast<size_t>(a) * work->stride;
    Scalar* to = batch->next_action(first) + a;
    for (int j = 0; j < n; ++j, action += action_size_, to += batch->stride()) {
      *to = Clip(*action + noise[j], Scalar{1});
    }
  }
}

template <typename Scalar>
double Td3<Scalar>::ActorLoss(Batch<Scalar>* batch) {
  for (Work& work : works_) work.actor_loss = 0;
  BatchFeeder complete;
  ForChunks(&team_, chunks_, &complete, &works_, [&](int first, int n, Accumulate accumulate, Work* work) {
    ActorChunk(batch, first, n, accumulate, work);
  });
  Work& sum = works_[0];
  for (size_t t = 1; t < works_.size(); ++t) {
    AddGradient(works_[t].policy_gradient, &policy_.gradient);
    sum.actor_loss += works_[t].actor_loss;
  }
  return sum.actor_loss / batch->size();
}

template <typename Scalar>
void Td3<Scalar>::ActorChunk(Batch<Scalar>* batch, int first, int n, Accumulate accumulate, Work* work) {
  policy_mlp_.LossGradient(policy_.weights, batch->input(first), n, accumulate, &work->policy_tape,
                           GradientOf(&policy_, &work->policy_gradient),
                           [&](int offset, int count, const Scalar* y, Scalar* d_y) {
                             ActorBlock(batch, first + offset, count, y, d_y, work);
                           });
}

// J_π = −mean Q_1(s, π(s)), π(s) = tanh(y)
template <typename Scalar>
void Td3<Scalar>::ActorBlock(Batch<Scalar>* batch, int first, int n, const Scalar* y, Scalar* d_y, Work* work) {
  const int size = n * action_size_;
  Tanh(y, size, work->action.data());
  for (int j = 0; j < n; ++j) std::copy_n(&work->action[j * action_size_], action_size_, batch->action(first + j));
  critics_.FirstQ(batch->input(first), n, &work->critics, work->q.data());
  const Scalar* q = work->q.data();
  work->actor_loss -= cairn::layers::LaneSum<double>(n, [q](int j) { return static_cast<double>(q[j]); });
  const Scalar* d_action = critics_.FirstActionGradient(n, &work->critics);
  const Scalar* action = work->action.data();
  const Scalar weight = Scalar{-1} / static_cast<Scalar>(batch->size());
  AtFullWidth([=]() CAIRN_INLINE_LOOP {  // da / dy = 1 − a²
    for (int i = 0; i < size; ++i) d_y[i] = weight * d_action[i] * (Scalar{1} - action[i] * action[i]);
  });
}

template <typename Scalar>
void Td3<Scalar>::VisitWeights(const std::function<void(std::string_view, std::span<const Scalar>)>& visit) const {
  visit("policy", policy_.parameters());
  visit("target_policy", {policy_target_.values.data(), policy_target_.values.size()});
  critics_.VisitWeights(visit);
}

template <typename Scalar>
void Td3<Scalar>::VisitState(const StateVisitor& visit) {
  policy_.VisitState("policy", visit);
  VisitNumbers(visit, "target_policy", true, policy_target_.values.data(), policy_target_.values.size());
  critics_.VisitState(visit);
  VisitNumbers(visit, "updates", false, &num_updates_, 1);
}

template <typename Scalar>
void Td3<Scalar>::StateChanged() {
  policy_mlp_.RefreshTransposed(&policy_.weights);
  policy_mlp_.RefreshTransposed(&policy_target_);
  critics_.StateChanged();
}

template <typename Scalar>
void Td3<Scalar>::ResetOptimizers() {
  policy_.adam.Reset();
  critics_.ResetOptimizers();
}

template class Td3<float>;
template class Td3<double>;

}  // namespace cairn::learner
