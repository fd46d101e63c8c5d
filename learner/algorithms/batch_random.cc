#include "learner/algorithms/batch_random.h"

#include <algorithm>
#include <cmath>

#include "common/core/random.h"
#include "common/nn/full_width.h"
#include "common/nn/vector_math.h"

namespace cairn::learner {
namespace {

constexpr int kLanes = 16;  // counters whose numbers stand together: first those of c[0], …, last those of c[3]
constexpr int kBlock = 4 * kLanes;  // numbers
constexpr int kBlocks = 2;          // that one pass makes: each waits for its own multiplications most of the time
constexpr int kPass = kBlocks * kBlock;
using Lanes = uint32_t[kBlocks * kLanes];

struct Counters {
  Lanes c[4];
};

// high : low = a · b
CAIRN_INLINE_LOOP inline void Multiply(uint32_t a, const Lanes& b, Lanes& high, Lanes& low) {
  for (int l = 0; l < kBlocks * kLanes; ++l) {
    const uint64_t product = uint64_t{a} * b[l];
    high[l] = static_cast<uint32_t>(product >> 32);
    low[l] = static_cast<uint32_t>(product);
  }
}

// Lane l holds counter (block · kLanes + l, purpose, draw) and so those of kBlocks blocks; afterwards c[0…3] are its
// four numbers.
CAIRN_INLINE_LOOP inline void Philox(std::array<uint32_t, 2> key, uint32_t block, uint32_t purpose, int64_t draw,
                                     Counters* counters) {
  auto& c = counters->c;
  for (int l = 0; l < kBlocks * kLanes; ++l) {
    c[0][l] = block * kLanes + static_cast<uint32_t>(l);
    c[1][l] = purpose;
    c[2][l] = static_cast<uint32_t>(draw);
    c[3][l] = static_cast<uint32_t>(static_cast<uint64_t>(draw) >> 32);
  }
  for (int round = 0; round < 10; ++round) {
    Lanes high0, low0, high1, low1;
    Multiply(0xD2511F53u, c[0], high0, low0);
    Multiply(0xCD9E8D57u, c[2], high1, low1);
    for (int l = 0; l < kBlocks * kLanes; ++l) {
      c[0][l] = high1[l] ^ c[1][l] ^ key[0];
      c[1][l] = low1[l];
      c[2][l] = high0[l] ^ c[3][l] ^ key[1];
      c[3][l] = low0[l];
    }
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
}

// Two uniforms of 24 bits, u in (0, 1] and v in [0, 1) → two normals.
CAIRN_INLINE_LOOP inline void BoxMuller(const uint32_t* a, const uint32_t* b, float* out) {
  for (int l = 0; l < kLanes; ++l) {
    const float u = static_cast<float>(static_cast<int32_t>(a[l] >> 8) + 1) * 0x1.0p-24f;
    const float v = static_cast<float>(static_cast<int32_t>(b[l] >> 8)) * 0x1.0p-24f;
    const float radius = std::sqrt(-2.0f * math::Log(u));
    float cosine, sine;
    math::CosSin2Pi(v, &cosine, &sine);
    out[l] = radius * cosine;
    out[kLanes + l] = radius * sine;
  }
}

// Numbers [first, first + n): make(block, to) writes those of a whole pass, parts of one go by way of a temporary.
template <typename T, typename Make>
CAIRN_INLINE_LOOP inline void InPasses(int first, int n, T* out, const Make& make) {
  T whole[kPass];
  for (int i = first, count; i < first + n; i += count, out += count) {
    const int skip = i % kPass;
    count = std::min(kPass - skip, first + n - i);
    make(static_cast<uint32_t>(i / kPass * kBlocks), whole);
    std::copy_n(whole + skip, count, out);
  }
}

}  // namespace

BatchRandom::BatchRandom(uint64_t seed) {
  RandomStream stream(seed, RandomPurpose::kUpdate);
  key_ = {stream.NextU32(), stream.NextU32()};
}

void BatchRandom::Bits(Purpose purpose, int64_t draw, int n, uint32_t* out) const {
  AtFullWidth([&]() CAIRN_INLINE_LOOP {
    InPasses(0, n, out, [&](uint32_t block, uint32_t* to) CAIRN_INLINE_LOOP {
      Counters counters;
      Philox(key_, block, static_cast<uint32_t>(purpose), draw, &counters);
      for (int b = 0; b < kBlocks; ++b) {
        for (int i = 0; i < 4; ++i) std::copy_n(counters.c[i] + b * kLanes, kLanes, to + b * kBlock + i * kLanes);
      }
    });
  });
}

void BatchRandom::Below(Purpose purpose, int64_t draw, uint32_t below, int n, uint32_t* out) const {
  Bits(purpose, draw, n, out);
  for (int i = 0; i < n; ++i) out[i] = static_cast<uint32_t>((uint64_t{out[i]} * below) >> 32);
}

void BatchRandom::Normals(Purpose purpose, int64_t draw, int first, int n, float* out) const {
  AtFullWidth([&]() CAIRN_INLINE_LOOP {
    InPasses(first, n, out, [&](uint32_t block, float* to) CAIRN_INLINE_LOOP {
      Counters counters;
      Philox(key_, block, static_cast<uint32_t>(purpose), draw, &counters);
      const auto& c = counters.c;
      for (int b = 0; b < kBlocks; ++b) {
        BoxMuller(c[0] + b * kLanes, c[1] + b * kLanes, to + b * kBlock);
        BoxMuller(c[2] + b * kLanes, c[3] + b * kLanes, to + b * kBlock + 2 * kLanes);
      }
    });
  });
}

}  // namespace cairn::learner
