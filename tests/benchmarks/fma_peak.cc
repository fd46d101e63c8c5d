#include "tests/benchmarks/fma_peak.h"

#include <benchmark/benchmark.h>

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace cairn {
namespace {

constexpr int kChains = 12;  // latency 4 × 2 units a cycle, and some
constexpr double kMultiplier = 0.999;

#ifdef __x86_64__
__attribute__((target("avx512f"))) float Chains512(int64_t rounds) {
  const __m512 x = _mm512_set1_ps(static_cast<float>(kMultiplier)), y = _mm512_set1_ps(1e-3f);
  __m512 chain[kChains];
  for (auto& c : chain) c = y;
  for (int64_t i = 0; i < rounds; ++i) {
#pragma GCC unroll 12
    for (int k = 0; k < kChains; ++k) chain[k] = _mm512_fmadd_ps(chain[k], x, y);
  }
  __m512 sum = chain[0];
  for (int k = 1; k < kChains; ++k) sum = _mm512_add_ps(sum, chain[k]);
  return _mm512_cvtss_f32(sum);
}

__attribute__((target("avx2,fma"))) float Chains256(int64_t rounds) {
  const __m256 x = _mm256_set1_ps(static_cast<float>(kMultiplier)), y = _mm256_set1_ps(1e-3f);
  __m256 chain[kChains];
  for (auto& c : chain) c = y;
  for (int64_t i = 0; i < rounds; ++i) {
#pragma GCC unroll 12
    for (int k = 0; k < kChains; ++k) chain[k] = _mm256_fmadd_ps(chain[k], x, y);
  }
  __m256 sum = chain[0];
  for (int k = 1; k < kChains; ++k) sum = _mm256_add_ps(sum, chain[k]);
  return _mm256_cvtss_f32(sum);
}
#endif

float Chains32(int64_t rounds) {
  const auto x = static_cast<float>(kMultiplier);
  float chain[kChains] = {};
  for (int64_t i = 0; i < rounds; ++i) {
    for (int k = 0; k < kChains; ++k) chain[k] = __builtin_fmaf(chain[k], x, 1e-3f);
  }
  float sum = 0;
  for (float c : chain) sum += c;
  return sum;
}

int WidthOf(const std::string& target) {
#ifdef __x86_64__
  for (const char* name : {"knl", "knm", "skx", "clx", "cpx", "spr"}) {
    if (target == name && __builtin_cpu_supports("avx512f")) return 512;
  }
  if (__builtin_cpu_supports("fma")) return 256;
#endif
  (void)target;
  return 32;
}

}  // namespace

FmaPeak::FmaPeak(const std::string& target) : width_(WidthOf(target)) {}

double FmaPeak::Run(double flops) {
  const double flops_per_round = 2.0 * kChains * width_ / 32;
  const auto rounds = static_cast<int64_t>(flops / flops_per_round) + 1;
#ifdef __x86_64__
  if (width_ == 512) sink_ += Chains512(rounds);
  if (width_ == 256) sink_ += Chains256(rounds);
#endif
  if (width_ == 32) sink_ += Chains32(rounds);
  benchmark::DoNotOptimize(sink_);
  return static_cast<double>(rounds) * flops_per_round;
}

}  // namespace cairn
