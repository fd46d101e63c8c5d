#pragma once

#include <array>
#include <cstdint>

namespace cairn::learner {

/// Random numbers by the thousand: Philox4x32-10 (Salmon et al. 2011) for many counters at once. The i-th number of
/// draw number `draw` is a pure function of (seed, purpose, draw, i), so nothing but the number of updates need be
/// saved and the bits do not depend on how many are drawn.
class BatchRandom {
 public:
  enum class Purpose : uint32_t { kReplayRows = 1, kNoise = 2, kNextNoise = 3 };

  explicit BatchRandom(uint64_t seed);
  explicit BatchRandom(std::array<uint32_t, 2> key) : key_(key) {}

  /// `n` integers, uniform over 32 bits.
  void Bits(Purpose purpose, int64_t draw, int n, uint32_t* out) const;

  /// `n` integers, uniform in [0, below).
  void Below(Purpose purpose, int64_t draw, uint32_t below, int n, uint32_t* out) const;

  /// Numbers [first, first + n) of the draw: standard normals (Box-Muller, both of a pair).
  void Normals(Purpose purpose, int64_t draw, int first, int n, float* out) const;

 private:
  std::array<uint32_t, 2> key_;
};

}  // namespace cairn::learner
