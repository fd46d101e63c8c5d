#include "common/core/random.h"

#include <cmath>
#include <numbers>

namespace cairn {
namespace {

uint64_t Mix(uint64_t x) {  // SplitMix64's finaliser: spreads nearby seeds over the key space
  x += 0x9E3779B97F4A7C15ull;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
  return x ^ (x >> 31);
}

std::array<uint32_t, 4> Philox(std::array<uint32_t, 4> c, std::array<uint32_t, 2> k) {
  for (int round = 0; round < 10; ++round) {
    const uint64_t p0 = uint64_t{0xD2511F53u} * c[0];
    const uint64_t p1 = uint64_t{0xCD9E8D57u} * c[2];
    c = {static_cast<uint32_t>(p1 >> 32) ^ c[1] ^ k[0], static_cast<uint32_t>(p1),
         static_cast<uint32_t>(p0 >> 32) ^ c[3] ^ k[1], static_cast<uint32_t>(p0)};
    k[0] += 0x9E3779B9u;
    k[1] += 0xBB67AE85u;
  }
  return c;
}

}  // namespace

RandomStream::RandomStream(uint64_t seed, RandomPurpose purpose, uint32_t index, uint32_t sub) : nonce_{index, sub} {
  const uint64_t key = Mix(Mix(seed) ^ static_cast<uint64_t>(purpose));
  key_ = {static_cast<uint32_t>(key), static_cast<uint32_t>(key >> 32)};
}

void RandomStream::Refill() {
  const uint64_t block = position_ / 4;
  block_ = Philox({static_cast<uint32_t>(block), static_cast<uint32_t>(block >> 32), nonce_[0], nonce_[1]}, key_);
}

uint32_t RandomStream::NextU32() {
  if (position_ % 4 == 0) Refill();
  return block_[position_++ % 4];
}

uint64_t RandomStream::NextU64() {
  const uint64_t high = NextU32();
  return (high << 32) | NextU32();
}

double RandomStream::Uniform() { return static_cast<double>(NextU64() >> 11) * 0x1.0p-53; }

double RandomStream::Uniform(double low, double high) { return low + (high - low) * Uniform(); }

uint32_t RandomStream::Below(uint32_t n) { return static_cast<uint32_t>((uint64_t{NextU32()} * n) >> 32); }

double RandomStream::Normal() {
  const double u = (static_cast<double>(NextU32()) + 1.0) * 0x1.0p-32;  // (0, 1]
  const double v = static_cast<double>(NextU32()) * 0x1.0p-32;
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

void RandomStream::SetPosition(uint64_t position) {
  position_ = position;
  if (position_ % 4 != 0) Refill();
}

}  // namespace cairn
