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
#include "learner/algorithms/trained_mlp.h"
#include "learner/algorithms/twin_critic.h"
#include "learner/algorithms/update_team.h"

namespace cairn::learner {

/// Twin Delayed DDPG (Fujimoto et al. 2018, algorithm 1): clipped double Q-learning, target policy smoothing, and
/// policy and target updates every `policy_delay`-th time.
template <typename Scalar>
class Td3 {
 public:
  static constexpr bool kUsesNoise = false;  ///< Batch::noise(), besides next_noise()

  Td3(const LearnerConfig& config, const PolicyShape& shape, uint64_t seed);

  /// Uses the batch's transitions and next noise; overwrites its actions in a policy update. `feeder` may
  /// complete the batch meanwhile. Throws Error when a loss or a gradient is not finite.
  UpdateInfo Update(Batch<Scalar>* batch, double learning_rate, BatchFeeder* feeder);

  const Mlp<Scalar>& policy_mlp() const { return policy_mlp_; }
  TrainedMlp<Scalar>& policy() { return policy_; }
  const TrainedMlp<Scalar>& policy() const { return policy_; }
  MlpWeights<Scalar>& policy_target() { return policy_target_; }
  const MlpWeights<Scalar>& policy_target() const { return policy_target_; }
  TwinCritic<Scalar>& critics() { return critics_; }

  /// Calls visit(name, values) for everything that is learnt, in a fixed order.
  void VisitWeights(const std::function<void(std::string_view, std::span<const Scalar>)>& visit) const;

  /// Everything that Update changes and builds on.
  void VisitState(const StateVisitor& visit);
  /// To be called after VisitState changed something.
  void StateChanged();
  void ResetOptimizers();

  /// The losses and their gradients alone, without a step: what Update is made of (and what tests differentiate).
  /// Both critics, per sample: (Q_i(s, a) − y)², y = R + discount min_i Q'_i(s', clip(π'(s') + clip(ε, −c, c), −1, 1)).
  double CriticLoss(Batch<Scalar>* batch, BatchFeeder* feeder);
  /// −Q_1(s, π(s)).
  double ActorLoss(Batch<Scalar>* batch);

 private:
  /// What belongs to one share of the batch (UpdateTeam).
  struct Work {
    MlpTape<Scalar> policy_tape;
    AlignedBuffer<Scalar> policy_gradient;  // empty in the first share's (GradientOf)
    typename TwinCritic<Scalar>::Work critics;
    int stride;
    AlignedBuffer<Scalar> q;       // [samples]
    AlignedBuffer<Scalar> action;  // [action_size × samples]
    AlignedBuffer<Scalar> noise;   // of the target action, clipped, [samples × action_size]
    double actor_loss = 0;         // sum over the batch
  };

  Work MakeWork(int share) const;
  void CriticChunk(Batch<Scalar>* batch, int first, int n, Accumulate accumulate, Work* work);
  void SmoothedTargetAction(Batch<Scalar>* batch, int first, int n, Work* work);
  void ActorChunk(Batch<Scalar>* batch, int first, int n, Accumulate accumulate, Work* work);
  void ActorBlock(Batch<Scalar>* batch, int first, int n, const Scalar* y, Scalar* d_y, Work* work);

  LearnerConfig config_;
  int action_size_;
  Chunks chunks_;
  Mlp<Scalar> policy_mlp_;
  TrainedMlp<Scalar> policy_;
  MlpWeights<Scalar> policy_target_;
  TwinCritic<Scalar> critics_;
  int64_t num_updates_ = 0;
  std::vector<Work> works_;  // one a share
  UpdateTeam team_;
};

extern template class Td3<float>;
extern template class Td3<double>;

}  // namespace cairn::learner
