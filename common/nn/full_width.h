#pragma once

#include "common/nn/kernels.h"

/// Marks a lambda for AtFullWidth, and functions that its loops call.
#define CAIRN_INLINE_LOOP __attribute__((always_inline))

namespace cairn {
namespace internal {

#if defined(__x86_64__) && defined(__clang__)
#define CAIRN_AVX512 __attribute__((target("avx512f,avx512vl,avx512bw,avx512dq,avx512cd"), min_vector_width(512)))
#elif defined(__x86_64__)
#define CAIRN_AVX512 __attribute__((target("avx512f,avx512vl,avx512bw,avx512dq,avx512cd,prefer-vector-width=512")))
#else
#define CAIRN_AVX512
#endif

template <typename Loop>
CAIRN_AVX512 void RunWide(const Loop& loop) {
  loop();
}

#undef CAIRN_AVX512

}  // namespace internal

/// Runs `loop`, a lambda of plain element-wise loops: its copy for AVX-512 where kernels::HasAvx512, otherwise that for
/// the build's instruction set. Nothing is contracted or reordered, so both give the same bits. What the lambda does
/// not inline stays code for the build's instruction set, so no other file can get hold of AVX-512 code.
template <typename Loop>
inline void AtFullWidth(const Loop& loop) {
  if (kernels::HasAvx512()) {
    internal::RunWide(loop);
  } else {
    loop();
  }
}

}  // namespace cairn
