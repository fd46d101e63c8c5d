#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>

#include "common/nn/aligned_buffer.h"
#include "learner/algorithms/state_array.h"

namespace cairn::learner {

/// Adam (Kingma and Ba 2015, algorithm 1) with PyTorch's defaults: beta 0.9 and 0.999, epsilon 1e-8 outside the root.
template <typename Scalar>
class Adam {
 public:
  explicit Adam(size_t size) : first_(size), second_(size) {}

  /// One step of `values` against `gradient_scale` · `gradient`.
  void Step(double learning_rate, std::span<const Scalar> gradient, double gradient_scale, std::span<Scalar> values);

  /// As new: without moments.
  void Reset() {
    std::fill(first_.begin(), first_.end(), Scalar{0});
    std::fill(second_.begin(), second_.end(), Scalar{0});
    num_steps_ = 0;
  }

  int64_t num_steps() const { return num_steps_; }

  void VisitState(const std::string& name, const StateVisitor& visit) {
    VisitNumbers(visit, name + ".first", false, first_.data(), first_.size());
    VisitNumbers(visit, name + ".second", false, second_.data(), second_.size());
    VisitNumbers(visit, name + ".steps", false, &num_steps_, 1);
  }

 private:
  AlignedBuffer<Scalar> first_;   // running mean of the gradient
  AlignedBuffer<Scalar> second_;  // running mean of its square
  int64_t num_steps_ = 0;
};

extern template class Adam<float>;
extern template class Adam<double>;

/// target := (1 − tau) target + tau online (Lillicrap et al. 2016: soft update).
template <typename Scalar>
void Polyak(double tau, std::span<const Scalar> online, std::span<Scalar> target);

/// Σ g². Not finite when any entry is not.
template <typename Scalar>
double SquaredNorm(std::span<const Scalar> gradient);

/// Factor that brings a gradient of this squared norm down to `max_norm` (PyTorch's clip_grad_norm_); 1 when it is
/// shorter or `max_norm` is 0.
double ClipFactor(double squared_norm, double max_norm);

/// Linear decay from `start` at progress 0 to `start` · `final_fraction` at progress 1.
double LinearDecay(double start, double final_fraction, double progress);

}  // namespace cairn::learner
