#pragma once

namespace cairn::kernels {

/// The float loops between the matrix products, compiled once for the build's instruction set and once for AVX-512, and
/// chosen at run time. Matrices are [rows × columns], column-major without gaps, one sample per column. Both give the
/// same bits: sums over rows run in 16 fixed lanes, sums over columns in ascending order.
struct Table {
  const char* name;

  /// z := max(0, z + bias); NaN stays NaN.
  void (*bias_relu)(const float* bias, int rows, int columns, float* z);

  /// bias_relu and narrow_product in one pass: y [outs × columns], y_oj = offsets_o + Σ_i w_io max(0, z_ij + bias_i).
  /// Without `keep` z is of no meaning afterwards.
  void (*bias_relu_product)(const float* bias, const float* w, const float* offsets, int rows, int outs, int columns,
                            bool keep, float* z, float* y);

  /// y [outs × columns]: y_oj = offsets_o + Σ_i w_io x_ij, w [rows × outs]; for few outputs. `offsets` may be null.
  void (*narrow_product)(const float* w, const float* offsets, const float* x, int rows, int outs, int columns,
                         float* y);

  /// d := d where h > 0, else 0; sums += d over columns.
  void (*relu_backward)(const float* h, int rows, int columns, float* d, float* sums);

  /// Backward of bias_relu_product with one output: d := w e_j where h_j > 0, else 0; sums += d over columns;
  /// w_gradient += e_j h_j.
  void (*dot_backward)(const float* w, const float* e, const float* h, int rows, int columns, float* d, float* sums,
                       float* w_gradient);

  /// d_p := d_p where h_{samples_p} > 0, else 0, for `columns` columns p of d.
  void (*mask_samples)(const float* h, const int* samples, int rows, int columns, float* d);

  /// d_p := w where h_{samples_p} > 0, else 0.
  void (*mask_vector)(const float* w, const float* h, const int* samples, int rows, int columns, float* d);

  /// to [columns × rows] := the transpose of from [rows × columns].
  void (*transpose)(const float* from, int rows, int columns, float* to);
};

/// Whether this processor and the products' target (GemmTarget) have AVX-512 and the build knows it.
bool HasAvx512();

/// The widest that there is.
const Table& Best();

/// For tests and logs.
const Table& Base();

}  // namespace cairn::kernels
