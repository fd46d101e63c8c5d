#pragma once

#include "common/nn/aligned_buffer.h"

namespace cairn::learner {

/// The squashed Gaussian of SAC (Haarnoja et al. 2018, appendix C): u = mean + std · noise, a = tanh(u), for the
/// samples of one chunk. log_std is clamped to [−20, 2]. Keeps what the backward pass needs; one a thread. Arrays named
/// [samples × …] hold one action dimension per column, `stride()` entries apart.
template <typename Scalar>
class TanhGaussian {
 public:
  TanhGaussian(int action_size, int max_samples);

  /// `y` [2 · action_size × n] is the network's output: means, then log_stds, of one sample per column. `noise`
  /// [n × action_size] with `noise_stride`. The actions go to `action` + j · action_stride for sample j.
  void Sample(const Scalar* y, int n, const Scalar* noise, int noise_stride, Scalar* action, int action_stride);

  /// log π(a|s) of the last samples, [n].
  const Scalar* log_prob() const { return log_prob_.data(); }

  /// Derivatives `d_y` by the network's output of Σ_j factor (alpha log π(a_j|s_j) − Q_j), where `d_q_d_action`
  /// [n × action_size] with stride() are the derivatives of Q_j by a_j.
  void Backward(const Scalar* d_q_d_action, int n, Scalar alpha, Scalar factor, Scalar* d_y) const;

  int stride() const { return stride_; }

 private:
  int action_size_, stride_;
  AlignedBuffer<Scalar> action_;     // [samples × action_size]: tanh(u)
  AlignedBuffer<Scalar> slope_;      // [samples × action_size]: da/du = 1 − a²
  AlignedBuffer<Scalar> deviation_;  // [samples × action_size]: std · noise
  AlignedBuffer<Scalar> inside_;     // [samples × action_size]: 1 where log_std is not clamped, else 0
  AlignedBuffer<Scalar> log_prob_;   // [samples]
};

extern template class TanhGaussian<float>;
extern template class TanhGaussian<double>;

}  // namespace cairn::learner
