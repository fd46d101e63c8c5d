#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

/// Elementary functions of one float, without branches, calls or tables, so that a loop over them becomes vector code
/// for any instruction set *and* gives the same bits as one value alone: every fused multiply-add is written out, and
/// the whole tree is compiled with -ffp-contract=off. Within 2 units in the last place (tests/common/nn).
/// The double overloads are the reference: libm's, one value at a time.
namespace cairn::math {

inline float Fma(float a, float b, float c) { return __builtin_fmaf(a, b, c); }
inline double Fma(double a, double b, double c) { return __builtin_fma(a, b, c); }

namespace internal {
inline float FromBits(int32_t bits) { return std::bit_cast<float>(bits); }
inline int32_t ToBits(float x) { return std::bit_cast<int32_t>(x); }
/// 2^n for n in [-126, 127].
inline float PowerOfTwo(int32_t n) { return FromBits((n + 127) << 23); }
}  // namespace internal

/// e^x; 0 below -104, infinity above 88.73, NaN stays NaN.
inline float Exp(float x) {
  // x = n ln2 + r, |r| <= ln2 / 2; e^r by Cephes' polynomial; 2^n in two factors so that the ends stay exact.
  x = x > 89.0f ? 89.0f : x;
  x = x < -104.0f ? -104.0f : x;
  const float shifted = Fma(x, 1.44269504f, 12582912.0f);  // 1.5 * 2^23: rounds to the nearest integer
  const float n = shifted - 12582912.0f;
  float r = Fma(n, -0.693147182f, x);
  r = Fma(n, 1.90465430e-9f, r);
  float p = 1.9875691500e-4f;
  p = Fma(p, r, 1.3981999507e-3f);
  p = Fma(p, r, 8.3334519073e-3f);
  p = Fma(p, r, 4.1665795894e-2f);
  p = Fma(p, r, 1.6666665459e-1f);
  p = Fma(p, r, 5.0000001201e-1f);
  p = Fma(p, r * r, r) + 1.0f;
  const int32_t power = internal::ToBits(shifted) - internal::ToBits(12582912.0f);
  const int32_t half = power >> 1;
  return p * internal::PowerOfTwo(half) * internal::PowerOfTwo(power - half);
}

/// Natural logarithm; -infinity at 0, NaN below, infinity stays.
inline float Log(float x) {
  // x = 2^k (1 + f), sqrt(1/2) <= 1 + f < sqrt(2); FreeBSD's e_logf.c: s = f / (2 + f).
  const bool tiny = x < std::numeric_limits<float>::min();
  const float scaled = tiny ? x * 8388608.0f : x;
  const int32_t bits = internal::ToBits(scaled) - 0x3F3504F3;
  const float k = static_cast<float>(bits >> 23) - (tiny ? 23.0f : 0.0f);
  const float f = internal::FromBits((bits & 0x007FFFFF) + 0x3F3504F3) - 1.0f;
  const float s = f / (2.0f + f);
  const float z = s * s;
  const float w = z * z;
  const float even = w * Fma(w, 0.24279078841f, 0.40000972152f);
  const float odd = z * Fma(w, 0.28498786688f, 0.66666662693f);
  const float half_square = 0.5f * f * f;
  float y = Fma(s, half_square + (odd + even), k * 9.0580006145e-6f) - half_square;
  y = y + f;
  y = Fma(k, 0.69313812256f, y);
  y = x == std::numeric_limits<float>::infinity() ? x : y;
  y = x == 0.0f ? -std::numeric_limits<float>::infinity() : y;
  return x >= 0.0f ? y : std::numeric_limits<float>::quiet_NaN();
}

/// Hyperbolic tangent.
inline float Tanh(float x) {
  // Below 0.625 Cephes' odd polynomial; above 1 - 2 / (e^2|x| + 1).
  const float magnitude = std::fabs(x);
  const float z = x * x;
  float p = -5.70498872745e-3f;
  p = Fma(p, z, 2.06390887954e-2f);
  p = Fma(p, z, -5.37397155531e-2f);
  p = Fma(p, z, 1.33314422036e-1f);
  p = Fma(p, z, -3.33332819422e-1f);
  const float small = Fma(p * z, x, x);
  const float large = 1.0f - 2.0f / (Exp(2.0f * magnitude) + 1.0f);
  return magnitude < 0.625f ? small : std::copysign(large, x);
}

/// cos(2 pi t) and sin(2 pi t) for t in [0, 1].
inline void CosSin2Pi(float t, float* cosine, float* sine) {
  // Nearest quarter turn q, rest in [-pi/4, pi/4]: Cephes' polynomials, then swap and signs by q.
  const auto q = static_cast<int32_t>(Fma(t, 4.0f, 0.5f));
  const float a = Fma(static_cast<float>(q), -0.25f, t) * 6.28318531f;
  const float z = a * a;
  float s = Fma(z, -1.9515295891e-4f, 8.3321608736e-3f);
  s = Fma(z, s, -1.6666654611e-1f);
  s = Fma(s * z, a, a);
  float c = Fma(z, 2.443315711809948e-5f, -1.388731625493765e-3f);
  c = Fma(z, c, 4.166664568298827e-2f);
  c = Fma(z * z, c, Fma(z, -0.5f, 1.0f));
  const bool swap = (q & 1) != 0;
  const float first = swap ? s : c;
  const float second = swap ? c : s;
  *cosine = ((q + 1) & 2) != 0 ? -first : first;
  *sine = (q & 2) != 0 ? -second : second;
}

inline double Exp(double x) { return std::exp(x); }
inline double Log(double x) { return std::log(x); }
inline double Tanh(double x) { return std::tanh(x); }

}  // namespace cairn::math
