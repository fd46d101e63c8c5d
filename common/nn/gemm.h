#pragma once

#include <string>

namespace cairn {

/// What a product does with its result.
enum class Accumulate {
  kOverwrite,  ///< C = A B
  kAdd,        ///< C += A B
};

/// C = A B with column-major matrices and a fixed shape, chosen once at construction: libxsmm's JIT, which picks the
/// instruction set at run time, or a plain loop in the same order where libxsmm has no kernel.
/// float results are the same bits for every n, for AVX2 and AVX-512 and without libxsmm: each entry is one chain of
/// fused multiply-adds with ascending k, starting from 0 (kOverwrite) or from C (kAdd).
template <typename Scalar>
class Gemm {
 public:
  enum class Transpose { kNone, kB };

  /// A is [m × k] with leading dimension lda; B is [k × n] (kNone, ldb ≥ k) or [n × k] (kB, ldb ≥ n); C is [m × n].
  Gemm(int m, int n, int k, int lda, int ldb, int ldc, Transpose transpose = Transpose::kNone,
       Accumulate accumulate = Accumulate::kOverwrite);

  void operator()(const Scalar* a, const Scalar* b, Scalar* c) const {
    if (kernel_ != nullptr) {
      kernel_(a, b, c);
    } else {
      Loop(a, b, c);
    }
  }

  bool jit() const { return kernel_ != nullptr; }

 private:
  void Loop(const Scalar* a, const Scalar* b, Scalar* c) const;

  int m_, n_, k_, lda_, ldb_, ldc_;
  Transpose transpose_;
  Accumulate accumulate_;
  void (*kernel_)(const Scalar*, const Scalar*, Scalar*) = nullptr;
};

extern template class Gemm<float>;
extern template class Gemm<double>;

/// Instruction set that the kernels use, e.g. "cpx" or "hsw" (libxsmm's names); "loop" without libxsmm.
std::string GemmTarget();

}  // namespace cairn
