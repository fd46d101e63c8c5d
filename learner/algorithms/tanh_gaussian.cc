#include "learner/algorithms/tanh_gaussian.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"
#include "common/nn/full_width.h"
#include "common/nn/vector_math.h"

namespace cairn::learner {
namespace {

constexpr double kMinLogStd = -20.0;
constexpr double kMaxLogStd = 2.0;
constexpr double kLog2 = 0.693147180559945309;
constexpr double kHalfLog2Pi = 0.918938533204672742;

// One action dimension: mean → tanh(u), log_std → std · noise, and the rest as TanhGaussian keeps it.
// log π(a|s) = log N(u; mean, std) − log(1 − tanh² u). With e = exp(−2|u|), which never overflows, and without
// cancellation for large |u|: tanh |u| = (1 − e) / (1 + e), 1 − tanh² u = 4 e / (1 + e)².
template <typename Scalar>
CAIRN_INLINE_LOOP inline void Squash(const Scalar* __restrict noise, int n, Scalar* __restrict mean,
                                     Scalar* __restrict log_std, Scalar* __restrict slope, Scalar* __restrict inside,
                                     Scalar* __restrict log_prob) {
  const auto low = static_cast<Scalar>(kMinLogStd), high = static_cast<Scalar>(kMaxLogStd);
  const auto log2 = static_cast<Scalar>(kLog2), half_log_2_pi = static_cast<Scalar>(kHalfLog2Pi);
  // Three loops: the chain of one, exp → exp → log, is longer than the processor looks ahead.
  for (int j = 0; j < n; ++j) {
    const Scalar raw = log_std[j];
    const Scalar above = raw < low ? low : raw;
    const Scalar clamped = above > high ? high : above;
    inside[j] = clamped == raw ? Scalar{1} : Scalar{0};
    log_prob[j] += Scalar{-0.5} * noise[j] * noise[j] - clamped - half_log_2_pi;
    log_std[j] = math::Exp(clamped) * noise[j];
    mean[j] += log_std[j];
  }
  for (int j = 0; j < n; ++j) slope[j] = math::Exp(Scalar{-2} * std::fabs(mean[j]));
  for (int j = 0; j < n; ++j) {
    const Scalar e = slope[j];
    const Scalar log_slope = Scalar{2} * (log2 - std::fabs(mean[j]) - math::Log(Scalar{1} + e));
    const Scalar quotient = Scalar{1} / (Scalar{1} + e);
    log_prob[j] -= log_slope;
    slope[j] = Scalar{4} * e * quotient * quotient;
    mean[j] = std::copysign((Scalar{1} - e) * quotient, mean[j]);
  }
}

}  // namespace

template <typename Scalar>
TanhGaussian<Scalar>::TanhGaussian(int action_size, int max_samples)
    : action_size_(action_size),
      stride_((max_samples + 15) / 16 * 16),
      action_(static_cast<size_t>(action_size) * stride_),
      slope_(static_cast<size_t>(action_size) * stride_),
      deviation_(static_cast<size_t>(action_size) * stride_),
      inside_(static_cast<size_t>(action_size) * stride_),
      log_prob_(static_cast<size_t>(stride_)) {}

template <typename Scalar>
void TanhGaussian<Scalar>::Sample(const Scalar* y, int n, const Scalar* noise, int noise_stride, Scalar* action,
                                  int action_stride) {
  CAIRN_DCHECK(n <= stride_);
  std::fill_n(log_prob_.data(), n, Scalar{0});
  for (int a = 0; a < action_size_; ++a, noise += noise_stride) {
    const size_t column = static_cast<size_t>(a) * stride_;
    Scalar* tanh_u = action_.data() + column;
    Scalar* deviation = deviation_.data() + column;
    for (int j = 0; j < n; ++j) {
      tanh_u[j] = y[j * 2 * action_size_ + a];
      deviation[j] = y[j * 2 * action_size_ + action_size_ + a];
    }
    AtFullWidth([&]() CAIRN_INLINE_LOOP {
      Squash(noise, n, tanh_u, deviation, slope_.data() + column, inside_.data() + column, log_prob_.data());
    });
    for (int j = 0; j < n; ++j) action[static_cast<ptrdiff_t>(j) * action_stride + a] = tanh_u[j];
  }
}

// d log π / du = 2 a (the Gaussian's part is constant: its noise is given), d log π / d log_std = −1 besides;
// du / dmean = 1, du / dlog_std = std · noise, da / du = 1 − a².
template <typename Scalar>
void TanhGaussian<Scalar>::Backward(const Scalar* d_q_d_action, int n, Scalar alpha, Scalar factor, Scalar* d_y) const {
  for (int a = 0; a < action_size_; ++a) {
    const size_t column = static_cast<size_t>(a) * stride_;
    const Scalar* action = action_.data() + column;
    const Scalar* deviation = deviation_.data() + column;
    const Scalar* inside = inside_.data() + column;
    const Scalar* slope = slope_.data() + column;
    const Scalar* d_q = d_q_d_action + column;
    for (int j = 0; j < n; ++j) {
      const Scalar d_u = factor * (Scalar{2} * alpha * action[j] - d_q[j] * slope[j]);
      d_y[j * 2 * action_size_ + a] = d_u;
      d_y[j * 2 * action_size_ + action_size_ + a] = inside[j] * (d_u * deviation[j] - factor * alpha);
    }
  }
}

template class TanhGaussian<float>;
template class TanhGaussian<double>;

}  // namespace cairn::learner
