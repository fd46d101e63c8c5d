#pragma once

#include "common/nn/layers.h"
#include "common/nn/vector_math.h"

/// Backward counterparts of common/nn/layers.h. Matrices are [rows × columns], column-major without gaps; sums over
/// columns run in ascending order for each row, so they do not depend on the instruction set.
namespace cairn::learner::layers {

using cairn::layers::LaneSum;

/// d := d where h > 0, else 0; sum += Σ over columns of d.
template <typename Scalar>
inline void ReluBackward(const Scalar* h, int rows, int columns, Scalar* __restrict d, Scalar* __restrict sum) {
  for (int j = 0; j < columns; ++j, h += rows, d += rows) {
    for (int i = 0; i < rows; ++i) {
      d[i] = h[i] > Scalar{0} ? d[i] : Scalar{0};
      sum[i] += d[i];
    }
  }
}

/// Sum over columns: sum += Σ d.
template <typename Scalar>
inline void AddColumns(const Scalar* d, int rows, int columns, Scalar* __restrict sum) {
  for (int j = 0; j < columns; ++j, d += rows) {
    for (int i = 0; i < rows; ++i) sum[i] += d[i];
  }
}

/// Backward of h = ReLU(gain · x + offset): d := d / dx, and adds the derivatives by gain and offset.
template <typename Scalar>
inline void GainReluBackward(const Scalar* gain, const Scalar* x, const Scalar* h, int rows, int columns,
                             Scalar* __restrict d, Scalar* __restrict d_gain, Scalar* __restrict d_offset) {
  for (int j = 0; j < columns; ++j, x += rows, h += rows, d += rows) {
    for (int i = 0; i < rows; ++i) {
      const Scalar masked = h[i] > Scalar{0} ? d[i] : Scalar{0};
      d_gain[i] = math::Fma(masked, x[i], d_gain[i]);
      d_offset[i] += masked;
      d[i] = masked * gain[i];
    }
  }
}

/// Backward of one column x = (z − mean(z)) · inverse_std: d := inverse_std (d − mean(d) − x mean(d x)).
template <typename Scalar>
inline void NormalizeBackward(const Scalar* x, Scalar inverse_std, int rows, Scalar* __restrict d) {
  const Scalar n = static_cast<Scalar>(rows);
  const Scalar mean_d = LaneSum<Scalar>(rows, [d](int i) { return d[i]; }) / n;
  const Scalar mean_dx = LaneSum<Scalar>(rows, [d, x](int i) { return d[i] * x[i]; }) / n;
  for (int i = 0; i < rows; ++i) d[i] = inverse_std * (d[i] - mean_d - x[i] * mean_dx);
}

/// One column: d := d where h > 0, else 0.
template <typename Scalar>
inline void Mask(const Scalar* h, int rows, Scalar* __restrict d) {
  for (int i = 0; i < rows; ++i) d[i] = h[i] > Scalar{0} ? d[i] : Scalar{0};
}

/// y_o = bias_o + Σ_i w_t[i, o] x_i for each of n columns; w_t is [in × out], x [in × n], y [out × n]. For few outputs;
/// `bias` may be null.
template <typename Scalar>
inline void NarrowForward(const Scalar* w_t, const Scalar* bias, int in, int out, const Scalar* x, int n,
                          Scalar* __restrict y) {
  for (int j = 0; j < n; ++j, x += in, y += out) {
    for (int o = 0; o < out; ++o) {
      const Scalar* w = w_t + static_cast<ptrdiff_t>(o) * in;
      const Scalar sum = LaneSum<Scalar>(in, [w, x](int i) { return w[i] * x[i]; });
      y[o] = bias != nullptr ? sum + bias[o] : sum;
    }
  }
}

}  // namespace cairn::learner::layers
