#include "learner/algorithms/tanh_gaussian.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"
#include "common/nn/vector_math.h"

namespace cairn::learner {
namespace {

constexpr double kMinLogStd = -20.0;
constexpr double kMaxLogStd = 2.0;
constexpr double kLog2 = 0.693147180559945309;
constexpr double kHalfLog2Pi = 0.918938533204672742;

}  // namespace

template <typename Scalar>
TanhGaussian<Scalar>::TanhGaussian(int action_size, int max_samples)
    : action_size_(action_size),
      stride_((max_samples + 15) / 16 * 16),
      action_(static_cast<size_t>(action_size) * stride_),
      deviation_(static_cast<size_t>(action_size) * stride_),
      inside_(static_cast<size_t>(action_size) * stride_),
      log_prob_(static_cast<size_t>(stride_)) {}

template <typename Scalar>
void TanhGaussian<Scalar>::Sample(const Scalar* y, int n, const Scalar* noise, int noise_stride, Scalar* action,
                                  int action_stride) {
  CAIRN_DCHECK(n <= stride_);
  Scalar* __restrict log_prob = log_prob_.data();
  std::fill_n(log_prob, n, Scalar{0});
  for (int a = 0; a < action_size_; ++a, noise += noise_stride) {
    Scalar* __restrict mean = action_.data() + static_cast<size_t>(a) * stride_;
    Scalar* __restrict deviation = deviation_.data() + static_cast<size_t>(a) * stride_;
    Scalar* __restrict inside = inside_.data() + static_cast<size_t>(a) * stride_;
    for (int j = 0; j < n; ++j) {
      mean[j] = y[j * 2 * action_size_ + a];
      deviation[j] = y[j * 2 * action_size_ + action_size_ + a];
    }
    for (int j = 0; j < n; ++j) {
      // log π(a|s) = log N(u; mean, std) − log(1 − tanh² u), and
      // log(1 − tanh² u) = 2 (log 2 − |u| − log(1 + e^−2|u|)), which does not cancel.
      const Scalar raw = deviation[j];
      const auto low = static_cast<Scalar>(kMinLogStd), high = static_cast<Scalar>(kMaxLogStd);
      const Scalar log_std = raw < low ? low : (raw > high ? high : raw);
      const Scalar step = math::Exp(log_std) * noise[j];
      const Scalar u = mean[j] + step;
      const Scalar magnitude = std::fabs(u);
      const Scalar log_slope =
          Scalar{2} * (static_cast<Scalar>(kLog2) - magnitude - math::SoftplusOfMinus(Scalar{2} * magnitude));
      log_prob[j] += Scalar{-0.5} * noise[j] * noise[j] - log_std - static_cast<Scalar>(kHalfLog2Pi) - log_slope;
      inside[j] = log_std == raw ? Scalar{1} : Scalar{0};
      deviation[j] = step;
      mean[j] = math::Tanh(u);
    }
    for (int j = 0; j < n; ++j) action[static_cast<ptrdiff_t>(j) * action_stride + a] = mean[j];
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
    const Scalar* d_q = d_q_d_action + column;
    for (int j = 0; j < n; ++j) {
      const Scalar d_u = factor * (Scalar{2} * alpha * action[j] - d_q[j] * (Scalar{1} - action[j] * action[j]));
      d_y[j * 2 * action_size_ + a] = d_u;
      d_y[j * 2 * action_size_ + action_size_ + a] = inside[j] * (d_u * deviation[j] - factor * alpha);
    }
  }
}

template class TanhGaussian<float>;
template class TanhGaussian<double>;

}  // namespace cairn::learner
