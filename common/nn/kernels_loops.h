// The loops of kernels.h, for the instruction set of the including file and in its namespace CAIRN_KERNELS_NAMESPACE:
// not a header for others. Nothing here may be an inline function that other files see too, or the linker could choose
// the AVX-512 copy for a machine without it; so only intrinsics and this file's own functions are used.

#include <stddef.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "common/nn/kernels.h"

namespace cairn::kernels {
namespace CAIRN_KERNELS_NAMESPACE {
namespace {

constexpr int kLanes = 16;

#if defined(__AVX512F__)

struct Lanes {
  __m512 v;
};
inline Lanes Zero() { return {_mm512_setzero_ps()}; }
inline Lanes All(float x) { return {_mm512_set1_ps(x)}; }
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
inline void Sums(const Lanes (&x)[4], float* sums) {
  const __m256 ab = _mm256_hadd_ps(Fold(x[0]), Fold(x[1]));
  const __m256 cd = _mm256_hadd_ps(Fold(x[2]), Fold(x[3]));
  const __m256 abcd = _mm256_hadd_ps(ab, cd);
  _mm_storeu_ps(sums, _mm_add_ps(_mm256_castps256_ps128(abcd), _mm256_extractf128_ps(abcd, 1)));
}

#else

inline void Sums(const Lanes (&x)[4], float* sums) {
  for (int i = 0; i < 4; ++i) {
    float s[8];
    for (int l = 0; l < 8; ++l) s[l] = x[i].v[l] + x[i].v[l + 8];
    sums[i] = ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
  }
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

template <int N>
struct Width {
  static constexpr int value = N;
};

/// Rows by sixteen: whole(r) as long as 16 are left, then part(r, how many).
template <typename Whole, typename Part>
inline void ForRows(int rows, Whole whole, Part part) {
  int r = 0;
  for (; r + kLanes <= rows; r += kLanes) whole(r);
  if (r < rows) part(r, rows - r);
}

void BiasRelu(const float* bias, int rows, int columns, float* z) {
  for (int j = 0; j < columns; ++j, z += rows) {
    ForRows(
        rows, [&](int r) { Store(Relu(Add(Load(z + r), Load(bias + r))), z + r); },
        [&](int r, int n) { StorePart(Relu(Add(LoadPart(z + r, n), LoadPart(bias + r, n))), n, z + r); });
  }
}

template <int C>
inline void BiasReluDotTile(const float* bias, const float* w, float offset, int rows, float* z, float* y) {
  Lanes sum[4] = {Zero(), Zero(), Zero(), Zero()};
  ForRows(
      rows,
      [&](int r) {
        const Lanes b = Load(bias + r), weight = Load(w + r);
        for (int c = 0; c < C; ++c) {
          float* p = z + static_cast<ptrdiff_t>(c) * rows + r;
          const Lanes h = Relu(Add(Load(p), b));
          Store(h, p);
          sum[c] = Fma(weight, h, sum[c]);
        }
      },
      [&](int r, int n) {
        const Lanes b = LoadPart(bias + r, n), weight = LoadPart(w + r, n);
        for (int c = 0; c < C; ++c) {
          float* p = z + static_cast<ptrdiff_t>(c) * rows + r;
          const Lanes h = Relu(Add(LoadPart(p, n), b));
          StorePart(h, n, p);
          sum[c] = Fma(weight, h, sum[c]);
        }
      });
  float sums[4];
  Sums(sum, sums);
  for (int c = 0; c < C; ++c) y[c] = offset + sums[c];
}

void BiasReluDot(const float* bias, const float* w, float offset, int rows, int columns, float* z, float* y) {
  int j = 0;
  for (; j + 4 <= columns; j += 4)
    BiasReluDotTile<4>(bias, w, offset, rows, z + static_cast<ptrdiff_t>(j) * rows, y + j);
  for (; j < columns; ++j) BiasReluDotTile<1>(bias, w, offset, rows, z + static_cast<ptrdiff_t>(j) * rows, y + j);
}

/// C columns of x times O columns of w, C · O at most 12.
template <int C, int O>
inline void ProductTile(const float* w, const float* offsets, const float* x, int rows, int outs, float* y) {
  constexpr int kGroups = (C * O + 3) / 4;
  Lanes sum[kGroups][4];
  for (int g = 0; g < 4 * kGroups; ++g) sum[g / 4][g % 4] = Zero();
  const auto add = [&](int r, auto load) {
    Lanes column[C];
    for (int c = 0; c < C; ++c) column[c] = load(x + static_cast<ptrdiff_t>(c) * rows + r);
    for (int o = 0; o < O; ++o) {
      const Lanes weight = load(w + static_cast<ptrdiff_t>(o) * rows + r);
      for (int c = 0; c < C; ++c) {
        Lanes& s = sum[(c * O + o) / 4][(c * O + o) % 4];
        s = Fma(weight, column[c], s);
      }
    }
  };
  ForRows(
      rows, [&](int r) { add(r, [](const float* p) { return Load(p); }); },
      [&](int r, int n) { add(r, [n](const float* p) { return LoadPart(p, n); }); });
  float sums[4 * kGroups];
  for (int g = 0; g < kGroups; ++g) Sums(sum[g], sums + 4 * g);
  for (int c = 0; c < C; ++c) {
    for (int o = 0; o < O; ++o) {
      y[static_cast<ptrdiff_t>(c) * outs + o] = (offsets != nullptr ? offsets[o] : 0.0f) + sums[c * O + o];
    }
  }
}

template <int C>
inline void ProductColumns(const float* w, const float* offsets, const float* x, int rows, int outs, float* y) {
  int o = 0;
  const auto tiles = [&](auto width) {  // as many outputs at a time as the registers hold
    constexpr int kOutputs = decltype(width)::value;
    for (; o + kOutputs <= outs; o += kOutputs) {
      ProductTile<C, kOutputs>(w + static_cast<ptrdiff_t>(o) * rows, offsets != nullptr ? offsets + o : nullptr, x,
                               rows, outs, y + o);
    }
  };
#ifdef __AVX512F__
  tiles(Width<6>());
#endif
  tiles(Width<3>());
  tiles(Width<2>());
  tiles(Width<1>());
}

void NarrowProduct(const float* w, const float* offsets, const float* x, int rows, int outs, int columns, float* y) {
  int j = 0;
  for (; j + 2 <= columns; j += 2) {
    ProductColumns<2>(w, offsets, x + static_cast<ptrdiff_t>(j) * rows, rows, outs,
                      y + static_cast<ptrdiff_t>(j) * outs);
  }
  if (j < columns) {
    ProductColumns<1>(w, offsets, x + static_cast<ptrdiff_t>(j) * rows, rows, outs,
                      y + static_cast<ptrdiff_t>(j) * outs);
  }
}

/// R · 16 rows of all columns; more rows at a time hide the latency of the sums.
template <int R>
inline void ReluBackwardRows(const float* h, int rows, int columns, float* d, float* sums) {
  Lanes sum[R];
  for (int i = 0; i < R; ++i) sum[i] = Load(sums + i * kLanes);
  for (int j = 0; j < columns; ++j, h += rows, d += rows) {
    for (int i = 0; i < R; ++i) {
      const Lanes x = WherePositive(Load(h + i * kLanes), Load(d + i * kLanes));
      Store(x, d + i * kLanes);
      sum[i] = Add(sum[i], x);
    }
  }
  for (int i = 0; i < R; ++i) Store(sum[i], sums + i * kLanes);
}

void ReluBackward(const float* h, int rows, int columns, float* d, float* sums) {
  int r = 0;
  for (; r + 4 * kLanes <= rows; r += 4 * kLanes) ReluBackwardRows<4>(h + r, rows, columns, d + r, sums + r);
  for (; r + kLanes <= rows; r += kLanes) ReluBackwardRows<1>(h + r, rows, columns, d + r, sums + r);
  for (; r < rows; ++r) {
    for (ptrdiff_t i = r; i < static_cast<ptrdiff_t>(columns) * rows; i += rows) {
      d[i] = h[i] > 0.0f ? d[i] : 0.0f;
      sums[r] += d[i];
    }
  }
}

template <int R>
inline void DotBackwardRows(const float* w, const float* e, const float* h, int rows, int columns, float* d,
                            float* sums, float* w_gradient) {
  Lanes weight[R], sum[R], slope[R];
  for (int i = 0; i < R; ++i) {
    weight[i] = Load(w + i * kLanes);
    sum[i] = Load(sums + i * kLanes);
    slope[i] = Load(w_gradient + i * kLanes);
  }
  for (int j = 0; j < columns; ++j, h += rows, d += rows) {
    const Lanes error = All(e[j]);
    for (int i = 0; i < R; ++i) {
      const Lanes activation = Load(h + i * kLanes);
      const Lanes x = WherePositive(activation, Multiply(weight[i], error));
      Store(x, d + i * kLanes);
      sum[i] = Add(sum[i], x);
      slope[i] = Fma(error, activation, slope[i]);
    }
  }
  for (int i = 0; i < R; ++i) {
    Store(sum[i], sums + i * kLanes);
    Store(slope[i], w_gradient + i * kLanes);
  }
}

void DotBackward(const float* w, const float* e, const float* h, int rows, int columns, float* d, float* sums,
                 float* w_gradient) {
  int r = 0;
  for (; r + 2 * kLanes <= rows; r += 2 * kLanes) {
    DotBackwardRows<2>(w + r, e, h + r, rows, columns, d + r, sums + r, w_gradient + r);
  }
  for (; r + kLanes <= rows; r += kLanes) {
    DotBackwardRows<1>(w + r, e, h + r, rows, columns, d + r, sums + r, w_gradient + r);
  }
  for (; r < rows; ++r) {
    for (int j = 0; j < columns; ++j) {
      const ptrdiff_t i = static_cast<ptrdiff_t>(j) * rows + r;
      d[i] = h[i] > 0.0f ? w[r] * e[j] : 0.0f;
      sums[r] += d[i];
      w_gradient[r] = __builtin_fmaf(e[j], h[i], w_gradient[r]);
    }
  }
}

void MaskSamples(const float* h, const int* samples, int rows, int columns, float* d) {
  for (int p = 0; p < columns; ++p, d += rows) {
    const float* column = h + static_cast<ptrdiff_t>(samples[p]) * rows;
    ForRows(
        rows, [&](int r) { Store(WherePositive(Load(column + r), Load(d + r)), d + r); },
        [&](int r, int n) { StorePart(WherePositive(LoadPart(column + r, n), LoadPart(d + r, n)), n, d + r); });
  }
}

void MaskVector(const float* w, const float* h, const int* samples, int rows, int columns, float* d) {
  for (int p = 0; p < columns; ++p, d += rows) {
    const float* column = h + static_cast<ptrdiff_t>(samples[p]) * rows;
    ForRows(
        rows, [&](int r) { Store(WherePositive(Load(column + r), Load(w + r)), d + r); },
        [&](int r, int n) { StorePart(WherePositive(LoadPart(column + r, n), LoadPart(w + r, n)), n, d + r); });
  }
}

#ifdef __AVX2__

inline void Transpose8x8(const float* from, ptrdiff_t rows, float* to, ptrdiff_t columns) {
  __m256 a[8], b[8];
  for (int i = 0; i < 8; ++i) a[i] = _mm256_loadu_ps(from + i * rows);
  for (int i = 0; i < 8; i += 2) {
    b[i] = _mm256_unpacklo_ps(a[i], a[i + 1]);
    b[i + 1] = _mm256_unpackhi_ps(a[i], a[i + 1]);
  }
  for (int i = 0; i < 8; i += 4) {
    a[i] = _mm256_shuffle_ps(b[i], b[i + 2], 0x44);
    a[i + 1] = _mm256_shuffle_ps(b[i], b[i + 2], 0xEE);
    a[i + 2] = _mm256_shuffle_ps(b[i + 1], b[i + 3], 0x44);
    a[i + 3] = _mm256_shuffle_ps(b[i + 1], b[i + 3], 0xEE);
  }
  for (int i = 0; i < 4; ++i) {
    _mm256_storeu_ps(to + i * columns, _mm256_permute2f128_ps(a[i], a[i + 4], 0x20));
    _mm256_storeu_ps(to + (i + 4) * columns, _mm256_permute2f128_ps(a[i], a[i + 4], 0x31));
  }
}

#else

inline void Transpose8x8(const float* from, ptrdiff_t rows, float* to, ptrdiff_t columns) {
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 8; ++i) to[i * columns + j] = from[j * rows + i];
  }
}

#endif

void Transpose(const float* from, int rows, int columns, float* to) {
  const int whole_rows = rows / 8 * 8, whole_columns = columns / 8 * 8;
  const auto copy = [&](int i, int j) {
    to[static_cast<ptrdiff_t>(i) * columns + j] = from[static_cast<ptrdiff_t>(j) * rows + i];
  };
  for (int i = 0; i < whole_rows; i += 8) {
    for (int j = 0; j < whole_columns; j += 8) {
      Transpose8x8(from + static_cast<ptrdiff_t>(j) * rows + i, rows, to + static_cast<ptrdiff_t>(i) * columns + j,
                   columns);
    }
    for (int j = whole_columns; j < columns; ++j) {
      for (int k = i; k < i + 8; ++k) copy(k, j);
    }
  }
  for (int j = 0; j < columns; ++j) {
    for (int i = whole_rows; i < rows; ++i) copy(i, j);
  }
}

constexpr Table kTable = {CAIRN_KERNELS_NAME, BiasRelu,    BiasReluDot, NarrowProduct, ReluBackward,
                          DotBackward,        MaskSamples, MaskVector,  Transpose};

}  // namespace
}  // namespace CAIRN_KERNELS_NAMESPACE
}  // namespace cairn::kernels
