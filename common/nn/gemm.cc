#include "common/nn/gemm.h"

#include <algorithm>

#include "common/core/check.h"

#ifdef CAIRN_HAS_XSMM
#include <libxsmm.h>
#endif

namespace cairn {
namespace {

inline float Fma(float a, float b, float c) { return __builtin_fmaf(a, b, c); }
inline double Fma(double a, double b, double c) { return __builtin_fma(a, b, c); }

template <typename Scalar>
using Kernel = void (*)(const Scalar*, const Scalar*, Scalar*);

#ifdef CAIRN_HAS_XSMM
// For at most one AVX-512 register of rows and fewer than 12 columns libxsmm 1.17 hides the latency behind several
// accumulators per entry, which breaks the ascending chain and would make results depend on n.
bool SplitsTheChain(int m, int n) { return m <= 16 && n < 12; }

libxsmm_smmfunction Dispatch(int m, int n, int k, const int* ld, const float* alpha, const float* beta,
                             const int* flags, const int* prefetch) {
  return libxsmm_smmdispatch(m, n, k, &ld[0], &ld[1], &ld[2], alpha, beta, flags, prefetch);
}
libxsmm_dmmfunction Dispatch(int m, int n, int k, const int* ld, const double* alpha, const double* beta,
                             const int* flags, const int* prefetch) {
  return libxsmm_dmmdispatch(m, n, k, &ld[0], &ld[1], &ld[2], alpha, beta, flags, prefetch);
}

// libxsmm's defaults are beta = 1 and automatic prefetch, so everything is passed; a missing kernel is a silent NULL.
template <typename Scalar>
Kernel<Scalar> FindKernel(int m, int n, int k, const int* ld, bool transpose_b, Accumulate accumulate) {
  if (SplitsTheChain(m, n)) return nullptr;
  const Scalar alpha = 1;
  const Scalar beta = accumulate == Accumulate::kAdd ? 1 : 0;
  const int flags = transpose_b ? LIBXSMM_GEMM_FLAG_TRANS_B : LIBXSMM_GEMM_FLAG_NONE;
  const int prefetch = LIBXSMM_GEMM_PREFETCH_NONE;
  return reinterpret_cast<Kernel<Scalar>>(Dispatch(m, n, k, ld, &alpha, &beta, &flags, &prefetch));
}
#else
template <typename Scalar>
Kernel<Scalar> FindKernel(int, int, int, const int*, bool, Accumulate) {
  return nullptr;
}
#endif

}  // namespace

template <typename Scalar>
Gemm<Scalar>::Gemm(int m, int n, int k, int lda, int ldb, int ldc, Transpose transpose, Accumulate accumulate)
    : m_(m), n_(n), k_(k), lda_(lda), ldb_(ldb), ldc_(ldc), transpose_(transpose), accumulate_(accumulate) {
  CAIRN_CHECK(m > 0 && n > 0 && k > 0, "gemm {}x{}x{}", m, n, k);
  CAIRN_CHECK(lda >= m && ldc >= m && ldb >= (transpose == Transpose::kB ? n : k), "leading dimensions {} {} {}", lda,
              ldb, ldc);
  const int ld[] = {lda, ldb, ldc};
  kernel_ = FindKernel<Scalar>(m, n, k, ld, transpose == Transpose::kB, accumulate);
}

template <typename Scalar>
void Gemm<Scalar>::Loop(const Scalar* a, const Scalar* b, Scalar* c) const {
  const int step = transpose_ == Transpose::kB ? ldb_ : 1;
  for (int j = 0; j < n_; ++j) {
    const Scalar* b_j = b + static_cast<ptrdiff_t>(j) * (transpose_ == Transpose::kB ? 1 : ldb_);
    Scalar* __restrict c_j = c + static_cast<ptrdiff_t>(j) * ldc_;
    if (accumulate_ == Accumulate::kOverwrite) std::fill_n(c_j, m_, Scalar{0});
    for (int p = 0; p < k_; ++p) {
      const Scalar* a_p = a + static_cast<ptrdiff_t>(p) * lda_;
      const Scalar b_pj = b_j[static_cast<ptrdiff_t>(p) * step];
      for (int i = 0; i < m_; ++i) c_j[i] = Fma(a_p[i], b_pj, c_j[i]);
    }
  }
}

template class Gemm<float>;
template class Gemm<double>;

std::string GemmTarget() {
#ifdef CAIRN_HAS_XSMM
  return libxsmm_get_target_arch();
#else
  return "loop";
#endif
}

}  // namespace cairn
