#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/nn/aligned_buffer.h"
#include "learner/algorithms/batch.h"
#include "learner/algorithms/mlp.h"
#include "learner/algorithms/trained_mlp.h"

namespace cairn::learner {

/// Two critics Q_1, Q_2 (s, a) and their slowly following targets (Fujimoto et al. 2018), which SAC and TD3 share.
/// Functions with a Work argument treat one chunk of samples: inputs are columns observation | action, `input_stride`
/// apart.
template <typename Scalar>
class TwinCritic {
 public:
  /// What belongs to one share of the batch (UpdateTeam).
  struct Work {
    Work(const Mlp<Scalar>& mlp, int action_size, bool own_gradient);

    std::array<MlpTape<Scalar>, 2> tape;
    std::array<AlignedBuffer<int>, 2> chosen;  // samples of the last FirstQ or MinQ by the critic that gave the value
    std::array<int, 2> num_chosen{};
    AlignedBuffer<Scalar> d_input;                  // [action_size × samples]
    std::array<AlignedBuffer<Scalar>, 2> gradient;  // of the critics; empty in the first share's (GradientOf)
    double squared_error = 0;                       // sums over the samples and both critics
    double q = 0;
  };

  TwinCritic(const MlpShape& shape, int input_stride, const std::vector<int>& columns, int action_size, uint64_t seed);

  /// For share `share`, from 0 on.
  Work MakeWork(int share) const { return Work(mlp_, action_size_, share > 0); }

  /// min_i of the targets' Q_i: `q` [n].
  void MinTargetQ(const Scalar* input, int n, Work* work, Scalar* q) const;

  /// Adds the gradient of weight · ½ Σ_i Σ_j (Q_i − target_q_j)²; with
  /// kOverwrite, for the first samples of a batch, starts gradients and sums anew.
  void Regress(const Scalar* input, const Scalar* target_q, int n, Scalar weight, Accumulate accumulate, Work* work);

  /// Adds what Regress left in another share's `part` to the first one's `sum`.
  void AddRegression(const Work& part, Work* sum);

  /// One step of both optimizers after the last Regress of a batch.
  void Step(double learning_rate, double max_grad_norm);

  /// Q_1: `q` [n]; FirstActionGradient then differentiates it.
  void FirstQ(const Scalar* input, int n, Work* work, Scalar* q) const;

  /// min_i Q_i: `q` [n]; ActionGradient then differentiates each sample's smaller one only, which is exact.
  void MinQ(const Scalar* input, int n, Work* work, Scalar* q) const;

  /// dQ_1/da of the last FirstQ, [action_size × n], which stands in `work`.
  const Scalar* FirstActionGradient(int n, Work* work) const;

  /// dQ/da of the last MinQ: `d_action` [n × action_size], one action dimension per column, `stride` apart.
  void ActionGradient(Work* work, Scalar* d_action, int stride) const;

  void UpdateTargets(double tau);

  /// Calls visit(name, values) for critics and targets, in a fixed order.
  template <typename Visit>
  void VisitWeights(const Visit& visit) const {
    visit("q1", critics_[0].parameters());
    visit("q2", critics_[1].parameters());
    visit("target_q1", std::span<const Scalar>(targets_[0].values.data(), targets_[0].values.size()));
    visit("target_q2", std::span<const Scalar>(targets_[1].values.data(), targets_[1].values.size()));
  }

  void VisitState(const StateVisitor& visit) {
    critics_[0].VisitState("q1", visit);
    critics_[1].VisitState("q2", visit);
    VisitNumbers(visit, "target_q1", true, targets_[0].values.data(), targets_[0].values.size());
    VisitNumbers(visit, "target_q2", true, targets_[1].values.data(), targets_[1].values.size());
  }

  /// To be called after VisitState changed something.
  void StateChanged() {
    for (TrainedMlp<Scalar>& critic : critics_) mlp_.RefreshTransposed(&critic.weights);
    for (MlpWeights<Scalar>& target : targets_) mlp_.RefreshTransposed(&target);
  }

  void ResetOptimizers() {
    for (TrainedMlp<Scalar>& critic : critics_) critic.adam.Reset();
  }

  const Mlp<Scalar>& mlp() const { return mlp_; }
  TrainedMlp<Scalar>& critic(int i) { return critics_[i]; }
  const TrainedMlp<Scalar>& critic(int i) const { return critics_[i]; }
  MlpWeights<Scalar>& target(int i) { return targets_[i]; }
  const MlpWeights<Scalar>& target(int i) const { return targets_[i]; }

 private:
  Mlp<Scalar> mlp_;
  int action_size_;
  std::array<TrainedMlp<Scalar>, 2> critics_;
  std::array<MlpWeights<Scalar>, 2> targets_;
};

extern template class TwinCritic<float>;
extern template class TwinCritic<double>;

}  // namespace cairn::learner
