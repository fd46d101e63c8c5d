#pragma once

#include <cstddef>
#include <span>

#include "common/nn/kernels.h"
#include "common/nn/layers.h"
#include "common/nn/vector_math.h"

/// Backward counterparts of common/nn/layers.h. Matrices are [rows × columns], column-major without gaps; sums over
/// columns run in ascending order for each row, so they do not depend on the instruction set. The float overloads are
/// the fast ones (common/nn/kernels.h); the templates serve double, the reference.
namespace cairn::learner::layers {

using cairn::layers::LaneSum;

/// y_oj := offsets_o + Σ_i w_io max(0, z_ij + bias_i), w [rows × outs], y [outs × columns]. With `keep` z := what the
/// sum takes of it, otherwise z is of no meaning afterwards.
template <typename Scalar>
inline void BiasReluProduct(const Scalar* bias, const Scalar* w, const Scalar* offsets, int rows, int outs, int columns,
                            bool /*keep*/, Scalar* z, Scalar* y) {
  cairn::layers::BiasRelu(bias, rows, columns, z);
  cairn::layers::NarrowProduct(w, offsets, z, rows, outs, columns, y);
}
inline void BiasReluProduct(const float* bias, const float* w, const float* offsets, int rows, int outs, int columns,
                            bool keep, float* z, float* y) {
  kernels::Best().bias_relu_product(bias, w, offsets, rows, outs, columns, keep, z, y);
}

/// Backward of BiasReluProduct with one output for derivatives e_j by y_j: d := derivatives by z + bias, sums += those
/// by the bias, w_gradient += those by w.
template <typename Scalar>
inline void DotBackward(const Scalar* w, const Scalar* e, const Scalar* h, int rows, int columns, Scalar* __restrict d,
                        Scalar* __restrict sums, Scalar* __restrict w_gradient) {
  for (int j = 0; j < columns; ++j, h += rows, d += rows) {
    for (int i = 0; i < rows; ++i) {
      d[i] = h[i] > Scalar{0} ? w[i] * e[j] : Scalar{0};
      sums[i] += d[i];
      w_gradient[i] = math::Fma(e[j], h[i], w_gradient[i]);
    }
  }
}
inline void DotBackward(const float* w, const float* e, const float* h, int rows, int columns, float* d, float* sums,
                        float* w_gradient) {
  kernels::Best().dot_backward(w, e, h, rows, columns, d, sums, w_gradient);
}

/// d := d where h > 0, else 0; sums += Σ over columns of d.
template <typename Scalar>
inline void ReluBackward(const Scalar* h, int rows, int columns, Scalar* __restrict d, Scalar* __restrict sums) {
  for (int j = 0; j < columns; ++j, h += rows, d += rows) {
    for (int i = 0; i < rows; ++i) {
      d[i] = h[i] > Scalar{0} ? d[i] : Scalar{0};
      sums[i] += d[i];
    }
  }
}
inline void ReluBackward(const float* h, int rows, int columns, float* d, float* sums) {
  kernels::Best().relu_backward(h, rows, columns, d, sums);
}

/// Column p: d_p := d_p where h > 0 in column samples_p, else 0.
template <typename Scalar>
inline void MaskSamples(const Scalar* h, std::span<const int> samples, int rows, Scalar* __restrict d) {
  for (size_t p = 0; p < samples.size(); ++p, d += rows) {
    const Scalar* column = h + static_cast<ptrdiff_t>(samples[p]) * rows;
    for (int i = 0; i < rows; ++i) d[i] = column[i] > Scalar{0} ? d[i] : Scalar{0};
  }
}
inline void MaskSamples(const float* h, std::span<const int> samples, int rows, float* d) {
  kernels::Best().mask_samples(h, samples.data(), rows, static_cast<int>(samples.size()), d);
}

/// Column p: d_p := w where h > 0 in column samples_p, else 0.
template <typename Scalar>
inline void MaskVector(const Scalar* w, const Scalar* h, std::span<const int> samples, int rows, Scalar* __restrict d) {
  for (size_t p = 0; p < samples.size(); ++p, d += rows) {
    const Scalar* column = h + static_cast<ptrdiff_t>(samples[p]) * rows;
    for (int i = 0; i < rows; ++i) d[i] = column[i] > Scalar{0} ? w[i] : Scalar{0};
  }
}
inline void MaskVector(const float* w, const float* h, std::span<const int> samples, int rows, float* d) {
  kernels::Best().mask_vector(w, h, samples.data(), rows, static_cast<int>(samples.size()), d);
}

/// to [columns × rows] := the transpose of from [rows × columns].
template <typename Scalar>
inline void Transpose(const Scalar* from, int rows, int columns, Scalar* to) {
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < rows; ++i) to[static_cast<size_t>(i) * columns + j] = from[static_cast<size_t>(j) * rows + i];
  }
}
inline void Transpose(const float* from, int rows, int columns, float* to) {
  kernels::Best().transpose(from, rows, columns, to);
}

/// sum += Σ over columns of d, in four interleaved parts so that no addition waits for the one before it.
template <typename Scalar>
inline void AddColumns(const Scalar* d, int rows, int columns, Scalar* __restrict sum) {
  for (int i = 0; i < rows; ++i) {
    Scalar part[4] = {};
    const Scalar* entry = d + i;
    int j = 0;
    for (; j + 4 <= columns; j += 4, entry += 4 * static_cast<ptrdiff_t>(rows)) {
      for (int k = 0; k < 4; ++k) part[k] += entry[static_cast<ptrdiff_t>(k) * rows];
    }
    for (; j < columns; ++j, entry += rows) part[0] += *entry;
    sum[i] += (part[0] + part[1]) + (part[2] + part[3]);
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

}  // namespace cairn::learner::layers
