// The loops of kernels.h, for the instruction set of the including file and in its namespace CAIRN_KERNELS_NAMESPACE:
// not a header for others. Nothing here may be an inline function that other files see too, or the linker could choose
// the AVX-512 copy for a machine without it; so only intrinsics and this file's own functions are used.

#include <stddef.h>

#include <utility>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "common/nn/kernels.h"

namespace cairn::kernels {
namespace CAIRN_KERNELS_NAMESPACE {
namespace {

#include "common/nn/kernels_lanes.h"

template <int N>
struct Index {
  static constexpr int value = N;
};

/// f(Index<0>()), …, f(Index<N − 1>()): a loop whose counter is a constant, so that an array indexed by it stays in
/// registers (GCC 12 leaves it in memory otherwise).
template <typename F, int... I>
CAIRN_INLINE void Unrolled(F f, std::integer_sequence<int, I...>) {
  (f(Index<I>()), ...);
}
template <int N, typename F>
CAIRN_INLINE void Unrolled(F f) {
  Unrolled(f, std::make_integer_sequence<int, N>());
}

/// Rows by sixteen: whole(r) as long as 16 are left, then part(r, how many).
template <typename Whole, typename Part>
inline void ForRows(int rows, Whole whole, Part part) {
  int r = 0;
  for (; r + kLanes <= rows; r += kLanes) whole(r);
  if (r < rows) part(r, rows - r);
}

template <int C>
inline void BiasReluTile(const float* bias, int rows, float* z) {
  ForRows(
      rows,
      [&](int r) CAIRN_INLINE_LAMBDA {
        const Lanes b = Load(bias + r);
        Unrolled<C>([&](auto c) CAIRN_INLINE_LAMBDA {
          float* p = z + static_cast<ptrdiff_t>(c.value) * rows + r;
          Store(Relu(Add(Load(p), b)), p);
        });
      },
      [&](int r, int n) {
        for (int c = 0; c < C; ++c) {
          float* p = z + static_cast<ptrdiff_t>(c) * rows + r;
          StorePart(Relu(Add(LoadPart(p, n), LoadPart(bias + r, n))), n, p);
        }
      });
}

void BiasRelu(const float* bias, int rows, int columns, float* z) {
  int j = 0;
  for (; j + 4 <= columns; j += 4) BiasReluTile<4>(bias, rows, z + static_cast<ptrdiff_t>(j) * rows);
  for (; j < columns; ++j) BiasReluTile<1>(bias, rows, z + static_cast<ptrdiff_t>(j) * rows);
}

/// How a column enters a product: as it is, or after bias and ReLU, which are then stored in its place or not.
enum class Entry { kPlain, kActivated, kActivatedAndKept };

/// C columns; y_j := offset + w · max(0, z_j + bias).
template <int C, Entry E>
CAIRN_INLINE void BiasReluDotTile(const float* bias, const float* w, float offset, int rows, float* z, float* y) {
  Lanes sum[4];
  Unrolled<4>([&](auto c) CAIRN_INLINE_LAMBDA { sum[c.value] = First(offset); });
  const auto add = [&](auto c, Lanes h, Lanes weight) CAIRN_INLINE_LAMBDA {
    sum[c.value] = Fma(weight, h, sum[c.value]);
    return h;
  };
  int r = 0;
  for (; r + kLanes <= rows; r += kLanes) {
    const Lanes b = Load(bias + r), weight = Load(w + r);
    Unrolled<C>([&](auto c) CAIRN_INLINE_LAMBDA {
      float* p = z + static_cast<ptrdiff_t>(c.value) * rows + r;
      const Lanes h = add(c, Relu(Add(Load(p), b)), weight);
      if (E == Entry::kActivatedAndKept) Store(h, p);
    });
  }
  if (const int rest = rows - r; rest > 0) {
    const Lanes b = LoadPart(bias + r, rest), weight = LoadPart(w + r, rest);
    Unrolled<C>([&](auto c) CAIRN_INLINE_LAMBDA {
      float* p = z + static_cast<ptrdiff_t>(c.value) * rows + r;
      const Lanes h = add(c, Relu(Add(LoadPart(p, rest), b)), weight);
      if (E == Entry::kActivatedAndKept) StorePart(h, rest, p);
    });
  }
  float sums[4];
  Sums(sum[0], sum[1], sum[2], sum[3], sums);
  for (int c = 0; c < C; ++c) y[c] = sums[c];
}

template <Entry E>
inline void BiasReluDot(const float* bias, const float* w, float offset, int rows, int columns, float* z, float* y) {
  int j = 0;
  for (; j + 4 <= columns; j += 4)
    BiasReluDotTile<4, E>(bias, w, offset, rows, z + static_cast<ptrdiff_t>(j) * rows, y + j);
  for (; j < columns; ++j) BiasReluDotTile<1, E>(bias, w, offset, rows, z + static_cast<ptrdiff_t>(j) * rows, y + j);
}

/// C columns of x times O columns of w. `bias` only for an Entry that is activated.
template <int C, int O, Entry E>
CAIRN_INLINE void ProductTile(const float* bias, const float* w, const float* offsets, int rows, int outs, float* x,
                              float* y) {
  constexpr int kPadded = (C * O + 3) / 4 * 4;
  Lanes sum[kPadded];  // entry c · O + o
  Unrolled<kPadded>([&](auto i) CAIRN_INLINE_LAMBDA {
    sum[i.value] = i.value < C * O && offsets != nullptr ? First(offsets[i.value % O]) : Zero();
  });
  const auto add = [&](int r, auto load, auto store) CAIRN_INLINE_LAMBDA {
    Lanes column[C];
    Unrolled<C>([&](auto c) CAIRN_INLINE_LAMBDA {
      float* p = x + static_cast<ptrdiff_t>(c.value) * rows + r;
      column[c.value] = load(p);
      if (E != Entry::kPlain) column[c.value] = Relu(Add(column[c.value], load(bias + r)));
      if (E == Entry::kActivatedAndKept) store(column[c.value], p);
    });
    Unrolled<O>([&](auto o) CAIRN_INLINE_LAMBDA {
      const Lanes weight = load(w + static_cast<ptrdiff_t>(o.value) * rows + r);
      Unrolled<C>([&](auto c) CAIRN_INLINE_LAMBDA {
        constexpr int kEntry = decltype(c)::value * O + decltype(o)::value;
        sum[kEntry] = Fma(weight, column[c.value], sum[kEntry]);
      });
    });
  };
  int r = 0;
  for (; r + kLanes <= rows; r += kLanes) {
    add(
        r, [](const float* p) CAIRN_INLINE_LAMBDA { return Load(p); },
        [](Lanes v, float* p) CAIRN_INLINE_LAMBDA { Store(v, p); });
  }
  if (const int rest = rows - r; rest > 0) {
    add(
        r, [rest](const float* p) CAIRN_INLINE_LAMBDA { return LoadPart(p, rest); },
        [rest](Lanes v, float* p) CAIRN_INLINE_LAMBDA { StorePart(v, rest, p); });
  }
  const auto add_lanes = [&](float* to) CAIRN_INLINE_LAMBDA {
    Unrolled<kPadded / 4>([&](auto g) CAIRN_INLINE_LAMBDA {
      constexpr int kFirst = 4 * decltype(g)::value;
      Sums(sum[kFirst], sum[kFirst + 1], sum[kFirst + 2], sum[kFirst + 3], to + kFirst);
    });
  };
  if (kPadded == C * O && outs == O) return add_lanes(y);  // the tile is contiguous
  float sums[kPadded];
  add_lanes(sums);
  for (int c = 0; c < C; ++c) {
    for (int o = 0; o < O; ++o) y[static_cast<ptrdiff_t>(c) * outs + o] = sums[c * O + o];
  }
}

/// The first tile of outputs activates the columns; the others then find them as they are.
template <int C, Entry E>
inline void ProductColumns(const float* bias, const float* w, const float* offsets, int rows, int outs, float* x,
                           float* y) {
  constexpr Entry kFirst = E == Entry::kPlain ? E : Entry::kActivatedAndKept;
  int o = 0;
  const auto tile = [&](auto width, auto entry) CAIRN_INLINE_LAMBDA {
    constexpr int kOutputs = decltype(width)::value;
    ProductTile<C, kOutputs, static_cast<Entry>(decltype(entry)::value)>(
        bias, w + static_cast<ptrdiff_t>(o) * rows, offsets != nullptr ? offsets + o : nullptr, rows, outs, x, y + o);
    o += kOutputs;
  };
  const auto tiles = [&](auto width) CAIRN_INLINE_LAMBDA {  // as many outputs at a time as the registers hold
    constexpr int kOutputs = decltype(width)::value;
    if (o == 0 && outs == kOutputs) tile(width, Index<static_cast<int>(E)>());
    if (o == 0 && outs > kOutputs) tile(width, Index<static_cast<int>(kFirst)>());
    while (o + kOutputs <= outs) tile(width, Index<static_cast<int>(Entry::kPlain)>());
  };
#ifdef __AVX512F__
  if constexpr (C <= 2) tiles(Index<6>());
#endif
  tiles(Index<3>());
  tiles(Index<2>());
  tiles(Index<1>());
}

template <Entry E>
inline void Product(const float* bias, const float* w, const float* offsets, int rows, int outs, int columns, float* x,
                    float* y) {
  int j = 0;
  const auto tiles = [&](auto width) CAIRN_INLINE_LAMBDA {
    constexpr int kColumns = decltype(width)::value;
    for (; j + kColumns <= columns; j += kColumns) {
      ProductColumns<kColumns, E>(bias, w, offsets, rows, outs, x + static_cast<ptrdiff_t>(j) * rows,
                                  y + static_cast<ptrdiff_t>(j) * outs);
    }
  };
#ifdef __AVX512F__
  if (outs <= 3) tiles(Index<4>());
#endif
  tiles(Index<2>());
  tiles(Index<1>());
}

void NarrowProduct(const float* w, const float* offsets, const float* x, int rows, int outs, int columns, float* y) {
  Product<Entry::kPlain>(nullptr, w, offsets, rows, outs, columns, const_cast<float*>(x), y);  // nothing is stored
}

void BiasReluProduct(const float* bias, const float* w, const float* offsets, int rows, int outs, int columns,
                     bool keep, float* z, float* y) {
  if (outs == 1 && keep) {
    BiasReluDot<Entry::kActivatedAndKept>(bias, w, offsets[0], rows, columns, z, y);
  } else if (outs == 1) {
    BiasReluDot<Entry::kActivated>(bias, w, offsets[0], rows, columns, z, y);
  } else if (keep) {
    Product<Entry::kActivatedAndKept>(bias, w, offsets, rows, outs, columns, z, y);
  } else {
    Product<Entry::kActivated>(bias, w, offsets, rows, outs, columns, z, y);
  }
}

/// R · 16 rows of all columns; more rows at a time hide the latency of the sums.
template <int R>
inline void ReluBackwardRows(const float* h, int rows, int columns, float* d, float* sums) {
  Lanes sum[R];
  Unrolled<R>([&](auto i) CAIRN_INLINE_LAMBDA { sum[i.value] = Load(sums + i.value * kLanes); });
  for (int j = 0; j < columns; ++j, h += rows, d += rows) {
    Unrolled<R>([&](auto i) CAIRN_INLINE_LAMBDA {
      float* p = d + i.value * kLanes;
      const Lanes x = WherePositive(Load(h + i.value * kLanes), Load(p));
      Store(x, p);
      sum[i.value] = Add(sum[i.value], x);
    });
  }
  Unrolled<R>([&](auto i) CAIRN_INLINE_LAMBDA { Store(sum[i.value], sums + i.value * kLanes); });
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
  Unrolled<R>([&](auto i) CAIRN_INLINE_LAMBDA {
    weight[i.value] = Load(w + i.value * kLanes);
    sum[i.value] = Load(sums + i.value * kLanes);
    slope[i.value] = Load(w_gradient + i.value * kLanes);
  });
  for (int j = 0; j < columns; ++j, h += rows, d += rows) {
    const Lanes error = All(e[j]);
    Unrolled<R>([&](auto i) CAIRN_INLINE_LAMBDA {
      const Lanes activation = Load(h + i.value * kLanes);
      const Lanes x = WherePositive(activation, Multiply(weight[i.value], error));
      Store(x, d + i.value * kLanes);
      sum[i.value] = Add(sum[i.value], x);
      slope[i.value] = Fma(error, activation, slope[i.value]);
    });
  }
  Unrolled<R>([&](auto i) CAIRN_INLINE_LAMBDA {
    Store(sum[i.value], sums + i.value * kLanes);
    Store(slope[i.value], w_gradient + i.value * kLanes);
  });
}

void DotBackward(const float* w, const float* e, const float* h, int rows, int columns, float* d, float* sums,
                 float* w_gradient) {
  int r = 0;
#ifdef __AVX512F__
  for (; r + 4 * kLanes <= rows; r += 4 * kLanes) {
    DotBackwardRows<4>(w + r, e, h + r, rows, columns, d + r, sums + r, w_gradient + r);
  }
#endif
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

constexpr Table kTable = {CAIRN_KERNELS_NAME, BiasRelu,    BiasReluProduct, NarrowProduct, ReluBackward,
                          DotBackward,        MaskSamples, MaskVector,      Transpose};

}  // namespace
}  // namespace CAIRN_KERNELS_NAMESPACE
}  // namespace cairn::kernels
