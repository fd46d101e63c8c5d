// Sixteen floats side by side for the instruction set of the including file: a part of kernels_loops.h, which includes
// it inside its namespace. Only intrinsics, for the reason given there.

constexpr int kLanes = 16;

#define CAIRN_INLINE inline __attribute__((always_inline))
#define CAIRN_INLINE_LAMBDA __attribute__((always_inline))

#if defined(__AVX512F__)

struct Lanes {
  __m512 v;
};
inline Lanes Zero() { return {_mm512_setzero_ps()}; }
inline Lanes All(float x) { return {_mm512_set1_ps(x)}; }
inline Lanes First(float x) { return {_mm512_zextps128_ps512(_mm_set_ss(x))}; }
inline Lanes Load(const float* p) { return {_mm512_loadu_ps(p)}; }
inline void Store(Lanes x, float* p) { _mm512_storeu_ps(p, x.v); }
inline Lanes Add(Lanes a, Lanes b) { return {_mm512_add_ps(a.v, b.v)}; }
inline Lanes Multiply(Lanes a, Lanes b) { return {_mm512_mul_ps(a.v, b.v)}; }
inline Lanes Fma(Lanes a, Lanes b, Lanes c) { return {_mm512_fmadd_ps(a.v, b.v, c.v)}; }
inline Lanes Relu(Lanes x) { return {_mm512_max_ps(_mm512_setzero_ps(), x.v)}; }
/// x where h > 0, else 0.
inline Lanes WherePositive(Lanes h, Lanes x) {
  return {_mm512_maskz_mov_ps(_mm512_cmp_ps_mask(h.v, _mm512_setzero_ps(), _CMP_GT_OQ), x.v)};
}
inline __m256 Fold(Lanes x) {
  return _mm256_add_ps(_mm512_castps512_ps256(x.v), _mm256_castpd_ps(_mm512_extractf64x4_pd(_mm512_castps_pd(x.v), 1)));
}

#elif defined(__AVX2__)

struct Lanes {
  __m256 low, high;
};
inline Lanes Zero() { return {_mm256_setzero_ps(), _mm256_setzero_ps()}; }
inline Lanes All(float x) { return {_mm256_set1_ps(x), _mm256_set1_ps(x)}; }
inline Lanes First(float x) { return {_mm256_zextps128_ps256(_mm_set_ss(x)), _mm256_setzero_ps()}; }
inline Lanes Load(const float* p) { return {_mm256_loadu_ps(p), _mm256_loadu_ps(p + 8)}; }
inline void Store(Lanes x, float* p) {
  _mm256_storeu_ps(p, x.low);
  _mm256_storeu_ps(p + 8, x.high);
}
inline Lanes Add(Lanes a, Lanes b) { return {_mm256_add_ps(a.low, b.low), _mm256_add_ps(a.high, b.high)}; }
inline Lanes Multiply(Lanes a, Lanes b) { return {_mm256_mul_ps(a.low, b.low), _mm256_mul_ps(a.high, b.high)}; }
inline Lanes Fma(Lanes a, Lanes b, Lanes c) {
  return {_mm256_fmadd_ps(a.low, b.low, c.low), _mm256_fmadd_ps(a.high, b.high, c.high)};
}
inline Lanes Relu(Lanes x) {
  return {_mm256_max_ps(_mm256_setzero_ps(), x.low), _mm256_max_ps(_mm256_setzero_ps(), x.high)};
}
inline __m256 WherePositive(__m256 h, __m256 x) {
  return _mm256_and_ps(_mm256_cmp_ps(h, _mm256_setzero_ps(), _CMP_GT_OQ), x);
}
inline Lanes WherePositive(Lanes h, Lanes x) { return {WherePositive(h.low, x.low), WherePositive(h.high, x.high)}; }
inline __m256 Fold(Lanes x) { return _mm256_add_ps(x.low, x.high); }

#else

struct Lanes {
  float v[kLanes];
};
template <typename F>
inline Lanes Each(F f) {
  Lanes r;
  for (int l = 0; l < kLanes; ++l) r.v[l] = f(l);
  return r;
}
inline Lanes Zero() { return {}; }
inline Lanes All(float x) {
  return Each([&](int) { return x; });
}
inline Lanes First(float x) {
  return Each([&](int l) { return l == 0 ? x : 0.0f; });
}
inline Lanes Load(const float* p) {
  return Each([&](int l) { return p[l]; });
}
inline void Store(Lanes x, float* p) {
  for (int l = 0; l < kLanes; ++l) p[l] = x.v[l];
}
inline Lanes Add(Lanes a, Lanes b) {
  return Each([&](int l) { return a.v[l] + b.v[l]; });
}
inline Lanes Multiply(Lanes a, Lanes b) {
  return Each([&](int l) { return a.v[l] * b.v[l]; });
}
inline Lanes Fma(Lanes a, Lanes b, Lanes c) {
  return Each([&](int l) { return __builtin_fmaf(a.v[l], b.v[l], c.v[l]); });
}
inline Lanes Relu(Lanes x) {
  return Each([&](int l) { return x.v[l] < 0.0f ? 0.0f : x.v[l]; });
}
inline Lanes WherePositive(Lanes h, Lanes x) {
  return Each([&](int l) { return h.v[l] > 0.0f ? x.v[l] : 0.0f; });
}

#endif

#ifdef __AVX2__

/// The sums of four, each over its lanes: ((0+8 + 1+9) + (2+10 + 3+11)) + ((4+12 + 5+13) + (6+14 + 7+15)).
inline void Sums(Lanes a, Lanes b, Lanes c, Lanes d, float* sums) {
  const __m256 ab = _mm256_hadd_ps(Fold(a), Fold(b));
  const __m256 cd = _mm256_hadd_ps(Fold(c), Fold(d));
  const __m256 abcd = _mm256_hadd_ps(ab, cd);
  _mm_storeu_ps(sums, _mm_add_ps(_mm256_castps256_ps128(abcd), _mm256_extractf128_ps(abcd, 1)));
}

#else

inline float Sum(Lanes x) {
  float s[8];
  for (int l = 0; l < 8; ++l) s[l] = x.v[l] + x.v[l + 8];
  return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}
inline void Sums(Lanes a, Lanes b, Lanes c, Lanes d, float* sums) {
  sums[0] = Sum(a);
  sums[1] = Sum(b);
  sums[2] = Sum(c);
  sums[3] = Sum(d);
}

#endif

/// The first n < 16 lanes, the others 0.
inline Lanes LoadPart(const float* p, int n) {
  float padded[kLanes] = {};
  for (int l = 0; l < n; ++l) padded[l] = p[l];
  return Load(padded);
}

inline void StorePart(Lanes x, int n, float* p) {
  float padded[kLanes];
  Store(x, padded);
  for (int l = 0; l < n; ++l) p[l] = padded[l];
}
