#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>

#include "common/core/check.h"
#include "common/nn/aligned_buffer.h"
#include "learner/algorithms/mlp.h"
#include "learner/optim/adam.h"

namespace cairn::learner {

/// A network that is learnt: its weights, the gradient of the batch at hand and its optimizer.
template <typename Scalar>
struct TrainedMlp {
  /// Weights and biases uniform in ±1/√inputs of their layer (PyTorch's default), a function of (seed, index) alone.
  TrainedMlp(const Mlp<Scalar>& mlp, uint64_t seed, uint32_t index);

  std::span<const Scalar> parameters() const { return {weights.values.data(), weights.values.size()}; }
  std::span<const Scalar> finished_gradient() const { return {gradient.data(), weights.values.size()}; }

  void VisitState(const std::string& name, const StateVisitor& visit) {
    VisitNumbers(visit, name, true, weights.values.data(), weights.values.size());
    adam.VisitState(name + ".adam", visit);
  }

  MlpWeights<Scalar> weights;
  AlignedBuffer<Scalar> gradient;  // Mlp::MakeGradientBuffer
  Adam<Scalar> adam;
};

/// Where a share of the batch adds up its gradient: the first one, whose `own` is empty, in the network's buffer.
template <typename Scalar>
AlignedBuffer<Scalar>* GradientOf(TrainedMlp<Scalar>* network, AlignedBuffer<Scalar>* own) {
  return own->size() > 0 ? own : &network->gradient;
}

/// sum += part.
template <typename Scalar>
void AddGradient(const AlignedBuffer<Scalar>& part, AlignedBuffer<Scalar>* sum) {
  for (size_t i = 0; i < part.size(); ++i) (*sum)[i] += part[i];
}

/// A target network's start.
template <typename Scalar>
MlpWeights<Scalar> CopyWeights(const Mlp<Scalar>& mlp, const MlpWeights<Scalar>& from) {
  MlpWeights<Scalar> copy(mlp.shape());
  std::copy(from.values.begin(), from.values.end(), copy.values.begin());
  mlp.RefreshTransposed(&copy);
  return copy;
}

/// Finishes the gradients of networks that are clipped together, checks and applies them. Throws NonFiniteError, with
/// all weights unchanged, when a gradient is not finite; `what` names the networks there.
template <typename Scalar>
void ApplyGradients(const Mlp<Scalar>& mlp, std::span<TrainedMlp<Scalar>* const> networks, double learning_rate,
                    double max_grad_norm, const char* what);

/// A loss or gradient that is not finite; what it was for is not applied.
class NonFiniteError : public Error {
 public:
  using Error::Error;
};

/// Throws NonFiniteError naming the loss unless it is finite.
void CheckFinite(double loss, const char* name);

extern template struct TrainedMlp<float>;
extern template struct TrainedMlp<double>;

}  // namespace cairn::learner
