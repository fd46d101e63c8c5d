#pragma once

#include <vector>

#include "common/nn/aligned_buffer.h"
#include "common/nn/policy.h"
#include "learner/algorithms/state_array.h"
#include "learner/algorithms/twin_critic.h"

namespace cairn::learner {

/// What networks at rest think of states: min_i Q_i(s, π(s)) with π's deterministic action. One thread.
class SavedValues {
 public:
  /// `networks` is what Algorithm::Save gave. Throws Error naming an array that is missing or has another size.
  SavedValues(const PolicyShape& shape, const std::vector<StateArray>& networks);

  /// `observations` is [n × observation_size], one row per sample, `values` [n].
  void Evaluate(const float* observations, int n, float* values);

 private:
  static constexpr int kBatch = 64;

  void EvaluateBatch(const float* observations, int n, float* values);

  PolicyShape shape_;
  int stride_;
  Policy policy_;
  TwinCritic<float> critics_;
  TwinCritic<float>::Work work_;
  AlignedBuffer<float> input_;  // a batch of observation | action, `stride_` apart
  AlignedBuffer<float> actions_, values_;
};

}  // namespace cairn::learner
