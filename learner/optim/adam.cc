#include "learner/optim/adam.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"
#include "common/nn/full_width.h"
#include "common/nn/layers.h"
#include "common/nn/vector_math.h"

namespace cairn::learner {
namespace {

constexpr double kBeta1 = 0.9;
constexpr double kBeta2 = 0.999;
constexpr double kEpsilon = 1e-8;
// Moments below it count as 0, which no weight notices beside kEpsilon. Those of a unit that has died shrink step by
// step until they are subnormal, and stay so: dividing by or into such numbers takes a processor several times as long.
constexpr double kNegligible = 1e-36;

}  // namespace

template <typename Scalar>
void Adam<Scalar>::Step(double learning_rate, std::span<const Scalar> gradient, double gradient_scale,
                        std::span<Scalar> values) {
  CAIRN_DCHECK(gradient.size() == first_.size() && values.size() == first_.size());
  ++num_steps_;
  // theta -= lr m^ / (sqrt(v^) + epsilon), m^ = m / (1 - beta1^t), v^ = v / (1 - beta2^t)
  const double t = static_cast<double>(num_steps_);
  const auto scale = static_cast<Scalar>(gradient_scale);
  const auto step = static_cast<Scalar>(-learning_rate / (1.0 - std::pow(kBeta1, t)));
  const auto root_scale = static_cast<Scalar>(1.0 / std::sqrt(1.0 - std::pow(kBeta2, t)));
  const auto beta1 = static_cast<Scalar>(kBeta1), rest1 = static_cast<Scalar>(1.0 - kBeta1);
  const auto beta2 = static_cast<Scalar>(kBeta2), rest2 = static_cast<Scalar>(1.0 - kBeta2);
  const auto epsilon = static_cast<Scalar>(kEpsilon), negligible = static_cast<Scalar>(kNegligible);
  const Scalar* __restrict g = gradient.data();
  Scalar* __restrict m = first_.data();
  Scalar* __restrict v = second_.data();
  Scalar* __restrict theta = values.data();
  const size_t size = values.size();
  AtFullWidth([=]() CAIRN_INLINE_LOOP {
    for (size_t i = 0; i < size; ++i) {
      const Scalar slope = g[i] * scale;
      const Scalar mean = math::Fma(beta1, m[i], rest1 * slope);
      const Scalar square = math::Fma(beta2, v[i], rest2 * slope * slope);
      m[i] = std::fabs(mean) < negligible ? Scalar{0} : mean;
      v[i] = square < negligible ? Scalar{0} : square;
      theta[i] = math::Fma(step, m[i] / math::Fma(std::sqrt(v[i]), root_scale, epsilon), theta[i]);
    }
  });
}

template <typename Scalar>
void Polyak(double tau, std::span<const Scalar> online, std::span<Scalar> target) {
  const auto rate = static_cast<Scalar>(tau);
  const Scalar* __restrict from = online.data();
  Scalar* __restrict to = target.data();
  const size_t size = online.size();
  AtFullWidth([=]() CAIRN_INLINE_LOOP {
    for (size_t i = 0; i < size; ++i) to[i] = math::Fma(rate, from[i] - to[i], to[i]);
  });
}

template <typename Scalar>
double SquaredNorm(std::span<const Scalar> gradient) {
  const Scalar* g = gradient.data();
  return static_cast<double>(
      layers::LaneSum<Scalar>(static_cast<int>(gradient.size()), [g](int i) { return g[i] * g[i]; }));
}

double ClipFactor(double squared_norm, double max_norm) {
  if (max_norm <= 0) return 1.0;
  return std::min(1.0, max_norm / (std::sqrt(squared_norm) + 1e-6));
}

double LinearDecay(double start, double final_fraction, double progress) {
  return start * (1.0 + (final_fraction - 1.0) * std::clamp(progress, 0.0, 1.0));
}

template class Adam<float>;
template class Adam<double>;
template void Polyak(double, std::span<const float>, std::span<float>);
template void Polyak(double, std::span<const double>, std::span<double>);
template double SquaredNorm(std::span<const float>);
template double SquaredNorm(std::span<const double>);

}  // namespace cairn::learner
