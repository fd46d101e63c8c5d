#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "common/config/experiment.h"
#include "common/nn/policy.h"
#include "learner/algorithms/algorithm.h"
#include "learner/algorithms/batch.h"
#include "learner/algorithms/tanh_gaussian.h"
#include "learner/algorithms/trained_mlp.h"
#include "learner/algorithms/twin_critic.h"
#include "learner/algorithms/update_team.h"

namespace cairn::learner {

/// Soft Actor-Critic with automatic temperature (Haarnoja et al. 2018, arXiv:1812.05905, algorithm 1). One update is
/// one step of both critics, the policy, alpha and the targets, in this order, on one batch.
template <typename Scalar>
class Sac {
 public:
  static constexpr bool kUsesNoise = true;  ///< Batch::noise(), besides next_noise()

  Sac(const LearnerConfig& config, const PolicyShape& shape, uint64_t seed);

  /// Uses the batch's transitions, noise and next noise; overwrites its actions. `feeder` may complete the
  /// batch meanwhile. Throws Error when a loss or a gradient is not finite.
  UpdateInfo Update(Batch<Scalar>* batch, double learning_rate, BatchFeeder* feeder);

  double alpha() const;
  double log_alpha() const { return log_alpha_; }
  void SetLogAlpha(double log_alpha) { log_alpha_ = log_alpha; }
  const Mlp<Scalar>& policy_mlp() const { return policy_mlp_; }
  TrainedMlp<Scalar>& policy() { return policy_; }
  const TrainedMlp<Scalar>& policy() const { return policy_; }
  TwinCritic<Scalar>& critics() { return critics_; }

  /// Calls visit(name, values) for everything that is learnt, in a fixed order.
  void VisitWeights(const std::function<void(std::string_view, std::span<const Scalar>)>& visit) const;

  /// Everything that Update changes and builds on.
  void VisitState(const StateVisitor& visit);
  /// To be called after VisitState changed something.
  void StateChanged();
  void ResetOptimizers();

  /// The losses and their gradients alone, without a step: what Update is made of (and what tests differentiate).
  /// J_Q, both critics, per sample: ½ (Q_i(s, a) − y)², y = R + discount (min_i Q'_i(s', a') − alpha log π(a'|s')).
  double CriticLoss(Batch<Scalar>* batch, BatchFeeder* feeder);
  /// J_π: alpha log π(a|s) − min_i Q_i(s, a).
  double ActorLoss(Batch<Scalar>* batch);
  /// J(alpha) as a function of log alpha, and its derivative: −log alpha (mean log π + target entropy).
  double AlphaLoss() const;
  double AlphaGradient() const;

 private:
  /// What belongs to one share of the batch (UpdateTeam).
  struct Work {
    MlpTape<Scalar> policy_tape;
    AlignedBuffer<Scalar> policy_gradient;  // empty in the first share's (GradientOf)
    typename TwinCritic<Scalar>::Work critics;
    TanhGaussian<Scalar> head;
    AlignedBuffer<Scalar> q;         // [samples]
    AlignedBuffer<Scalar> d_action;  // [samples × action_size]
    double actor_loss = 0;           // sums over the batch
    double log_prob = 0;
  };

  Work MakeWork(int share) const;
  void CriticChunk(Batch<Scalar>* batch, int first, int n, Accumulate accumulate, Work* work);
  void ActorChunk(Batch<Scalar>* batch, int first, int n, Accumulate accumulate, Work* work);
  void ActorBlock(Batch<Scalar>* batch, int first, int n, const Scalar* y, Scalar* d_y, Work* work);

  LearnerConfig config_;
  int action_size_;
  Chunks chunks_;
  Mlp<Scalar> policy_mlp_;
  TrainedMlp<Scalar> policy_;
  TwinCritic<Scalar> critics_;
  double log_alpha_;
  Adam<double> alpha_adam_;
  double mean_log_prob_ = 0;  // of the last ActorLoss
  std::vector<Work> works_;   // one a share
  UpdateTeam team_;
};

extern template class Sac<float>;
extern template class Sac<double>;

}  // namespace cairn::learner
