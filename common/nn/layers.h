#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/nn/kernels.h"
#include "common/nn/vector_math.h"

/// What stands between two matrix products of a multi-layer perceptron. Matrices are [rows × columns], column-major,
/// one sample per column, without gaps. Each column's result has the same bits whatever the number of columns and the
/// instruction set: sums over rows go through 16 fixed lanes. The float overloads are the fast ones (kernels.h); the
/// templates serve double, the reference.
namespace cairn::layers {

inline constexpr double kLayerNormEpsilon = 1e-5;

/// Sum of term(i) over i < n in the fixed order.
template <typename Scalar, typename Term>
inline Scalar LaneSum(int n, Term term) {
  Scalar lane[16] = {};
  int i = 0;
  for (; i + 16 <= n; i += 16) {
    for (int l = 0; l < 16; ++l) lane[l] += term(i + l);
  }
  for (int l = 0; i + l < n; ++l) lane[l] += term(i + l);
  for (int width = 8; width > 0; width /= 2) {
    for (int l = 0; l < width; ++l) lane[l] += lane[l + width];
  }
  return lane[0];
}

/// z := z + bias.
template <typename Scalar>
inline void AddBias(const Scalar* bias, int rows, int columns, Scalar* __restrict z) {
  for (int j = 0; j < columns; ++j, z += rows) {
    for (int i = 0; i < rows; ++i) z[i] += bias[i];
  }
}

/// z := max(0, z + bias); NaN stays NaN.
template <typename Scalar>
inline void BiasRelu(const Scalar* bias, int rows, int columns, Scalar* __restrict z) {
  for (int j = 0; j < columns; ++j, z += rows) {
    for (int i = 0; i < rows; ++i) {
      const Scalar v = z[i] + bias[i];
      z[i] = v < Scalar{0} ? Scalar{0} : v;
    }
  }
}
inline void BiasRelu(const float* bias, int rows, int columns, float* z) {
  kernels::Best().bias_relu(bias, rows, columns, z);
}

/// y_o = offsets_o + Σ_i w_io x_i for each column x; w is [rows × outs], y [outs × columns]. For few outputs; `offsets`
/// may be null.
template <typename Scalar>
inline void NarrowProduct(const Scalar* w, const Scalar* offsets, const Scalar* x, int rows, int outs, int columns,
                          Scalar* __restrict y) {
  for (int j = 0; j < columns; ++j, x += rows, y += outs) {
    for (int o = 0; o < outs; ++o) {
      const Scalar* weights = w + static_cast<ptrdiff_t>(o) * rows;
      const Scalar sum = LaneSum<Scalar>(rows, [weights, x](int i) { return weights[i] * x[i]; });
      y[o] = offsets != nullptr ? offsets[o] + sum : sum;
    }
  }
}
inline void NarrowProduct(const float* w, const float* offsets, const float* x, int rows, int outs, int columns,
                          float* y) {
  kernels::Best().narrow_product(w, offsets, x, rows, outs, columns, y);
}

/// z := (z + bias - mean) / sqrt(variance + epsilon) for each column (Ba et al. 2016, equations 3-4). Writes the
/// factors 1 / sqrt(…) to `inverse_std` [columns] unless it is null.
template <typename Scalar>
inline void Normalize(const Scalar* bias, int rows, int columns, Scalar* __restrict z, Scalar* inverse_std) {
  for (int j = 0; j < columns; ++j, z += rows) {
    for (int i = 0; i < rows; ++i) z[i] += bias[i];
    const Scalar mean = LaneSum<Scalar>(rows, [z](int i) { return z[i]; }) / static_cast<Scalar>(rows);
    for (int i = 0; i < rows; ++i) z[i] -= mean;
    const Scalar variance = LaneSum<Scalar>(rows, [z](int i) { return z[i] * z[i]; }) / static_cast<Scalar>(rows);
    const Scalar factor = Scalar{1} / std::sqrt(variance + static_cast<Scalar>(kLayerNormEpsilon));
    for (int i = 0; i < rows; ++i) z[i] *= factor;
    if (inverse_std != nullptr) inverse_std[j] = factor;
  }
}

/// h := max(0, gain · x + offset); h may be x.
template <typename Scalar>
inline void GainRelu(const Scalar* gain, const Scalar* offset, int rows, int columns, const Scalar* x, Scalar* h) {
  for (int j = 0; j < columns; ++j, x += rows, h += rows) {
    for (int i = 0; i < rows; ++i) {
      const Scalar v = math::Fma(gain[i], x[i], offset[i]);
      h[i] = v < Scalar{0} ? Scalar{0} : v;
    }
  }
}

}  // namespace cairn::layers
