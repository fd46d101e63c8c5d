#pragma once

#include <memory>
#include <string>

namespace cairn {

/// C = A B with column-major matrices and a fixed shape, chosen once at construction (libxsmm's JIT, which picks the
/// instruction set at run time; Eigen where libxsmm has no kernel). beta is 0: C is overwritten.
/// float results are the same bits for every n and for AVX2 and AVX-512 (ascending-k fused multiply-add chains).
template <typename Scalar>
class Gemm {
 public:
  enum class Transpose { kNone, kB };

  /// A is [m × k] with leading dimension lda; B is [k × n] (kNone, ldb ≥ k) or [n × k] (kB, ldb ≥ n); C is [m × n].
  Gemm(int m, int n, int k, int lda, int ldb, int ldc, Transpose transpose = Transpose::kNone);

  void operator()(const Scalar* a, const Scalar* b, Scalar* c) const;

  bool jit() const { return kernel_ != nullptr; }

 private:
  int m_, n_, k_, lda_, ldb_, ldc_;
  Transpose transpose_;
  void (*kernel_)(const Scalar*, const Scalar*, Scalar*) = nullptr;
};

extern template class Gemm<float>;
extern template class Gemm<double>;

/// Instruction set that the kernels use, e.g. "cpx" or "hsw"; "eigen" without libxsmm.
std::string GemmTarget();

}  // namespace cairn
