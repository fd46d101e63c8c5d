// Compiled with -march=x86-64-v4 and called only where kernels::Best has found AVX-512.
#define CAIRN_KERNELS_NAMESPACE avx512
#define CAIRN_KERNELS_NAME "avx512"
#include "common/nn/kernels_loops.h"

namespace cairn::kernels {

const Table& Avx512();
const Table& Avx512() { return avx512::kTable; }

}  // namespace cairn::kernels
