#include "common/core/hash.h"

#include <xxhash.h>

#include <array>
#include <cstring>
#include <random>

#ifdef __SSE4_2__
#include <nmmintrin.h>
#endif

namespace cairn {
namespace {

#ifndef __SSE4_2__
constexpr std::array<uint32_t, 256> MakeTable() {
  std::array<uint32_t, 256> table{};
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t c = i;
    for (int k = 0; k < 8; ++k) c = (c & 1) ? (c >> 1) ^ 0x82F63B78u : c >> 1;
    table[i] = c;
  }
  return table;
}
constexpr std::array<uint32_t, 256> kTable = MakeTable();
#endif

}  // namespace

uint32_t Crc32c(const void* data, size_t size, uint32_t crc) {
  const auto* p = static_cast<const uint8_t*>(data);
#ifdef __SSE4_2__
  uint64_t c = ~crc;
  for (; size >= 8; p += 8, size -= 8) {
    uint64_t word;
    std::memcpy(&word, p, 8);
    c = _mm_crc32_u64(c, word);
  }
  auto c32 = static_cast<uint32_t>(c);
  for (; size > 0; ++p, --size) c32 = _mm_crc32_u8(c32, *p);
#else
  uint32_t c32 = ~crc;
  for (; size > 0; ++p, --size) c32 = kTable[(c32 ^ *p) & 0xFF] ^ (c32 >> 8);
#endif
  return ~c32;
}

uint64_t ContentHash(const void* data, size_t size, uint64_t seed) {
  const uint64_t h = XXH3_64bits_withSeed(data, size, seed);
  return h == 0 ? 1 : h;
}

int64_t RandomId() {
  std::random_device device;
  int64_t id = 0;
  while (id == 0) {
    id = static_cast<int64_t>(((static_cast<uint64_t>(device()) << 32) | device()) & 0x7FFFFFFFFFFFFFFFull);
  }
  return id;
}

}  // namespace cairn
