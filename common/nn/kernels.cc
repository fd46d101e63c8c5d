#define CAIRN_KERNELS_NAMESPACE base
#ifdef __AVX2__
#define CAIRN_KERNELS_NAME "avx2"
#else
#define CAIRN_KERNELS_NAME "loop"
#endif
#include <string>

#include "common/nn/gemm.h"
#include "common/nn/kernels_loops.h"

namespace cairn::kernels {

#ifdef CAIRN_HAS_AVX512_KERNELS
const Table& Avx512();  // kernels_avx512.cc
#endif

const Table& Base() { return base::kTable; }

bool HasAvx512() {
#ifdef CAIRN_HAS_AVX512_KERNELS
  static const bool wide = [] {
    const std::string target = GemmTarget();  // LIBXSMM_TARGET may ask for less than the processor has
    return target != "hsw" && target != "snb" && __builtin_cpu_supports("avx512f") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512cd");
  }();
  return wide;
#else
  return false;
#endif
}

const Table& Best() {
#ifdef CAIRN_HAS_AVX512_KERNELS
  if (HasAvx512()) return Avx512();
#endif
  return Base();
}

}  // namespace cairn::kernels
