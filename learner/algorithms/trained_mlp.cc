#include "learner/algorithms/trained_mlp.h"

#include <cmath>

#include "common/core/check.h"
#include "common/core/random.h"

namespace cairn::learner {

template <typename Scalar>
TrainedMlp<Scalar>::TrainedMlp(const Mlp<Scalar>& mlp, uint64_t seed, uint32_t index)
    : weights(mlp.shape()), gradient(mlp.MakeGradientBuffer()), adam(weights.values.size()) {
  RandomStream random(seed, RandomPurpose::kWeights, index);
  for (const MlpLayer& layer : mlp.layers()) {
    const double bound = 1.0 / std::sqrt(static_cast<double>(layer.in));
    // Rounded to float, so that the double path starts from the same weights.
    const auto draw = [&] { return static_cast<Scalar>(static_cast<float>(random.Uniform(-bound, bound))); };
    for (size_t i = layer.weights; i < layer.bias + layer.out; ++i) weights.values[i] = draw();
  }
  mlp.RefreshTransposed(&weights);
}

template <typename Scalar>
void ApplyGradients(const Mlp<Scalar>& mlp, std::span<TrainedMlp<Scalar>* const> networks, double learning_rate,
                    double max_grad_norm, const char* what) {
  double squared_norm = 0;
  for (TrainedMlp<Scalar>* network : networks) {
    mlp.FinishGradient(&network->gradient);
    squared_norm += SquaredNorm(network->finished_gradient());
  }
  if (!std::isfinite(squared_norm)) {
    throw NonFiniteError(fmt::format("gradient of the {} is not finite (squared norm {})", what, squared_norm));
  }
  const double factor = ClipFactor(squared_norm, max_grad_norm);
  for (TrainedMlp<Scalar>* network : networks) {
    auto& values = network->weights.values;
    network->adam.Step(learning_rate, network->finished_gradient(), factor, {values.data(), values.size()});
    mlp.RefreshTransposed(&network->weights);
  }
}

void CheckFinite(double loss, const char* name) {
  if (!std::isfinite(loss)) throw NonFiniteError(fmt::format("{} is {}", name, loss));
}

template struct TrainedMlp<float>;
template struct TrainedMlp<double>;
template void ApplyGradients(const Mlp<float>&, std::span<TrainedMlp<float>* const>, double, double, const char*);
template void ApplyGradients(const Mlp<double>&, std::span<TrainedMlp<double>* const>, double, double, const char*);

}  // namespace cairn::learner
