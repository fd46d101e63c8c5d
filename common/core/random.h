#pragma once

#include <array>
#include <cstdint>

namespace cairn {

/// What a stream of random numbers is for. Part of its key, so that no two uses share numbers. Values are frozen.
enum class RandomPurpose : uint32_t {
  kWorld = 1,
  kPlanner = 2,
  kStart = 3,
  kDisturbance = 4,
  kExploration = 5,
  kObservationNoise = 6,
  kParameters = 7,
  kWeights = 8,
  kReplay = 9,
  kUpdate = 10,
  kConsumptionStart = 11,
  kValidationStart = 12,
  kTestStart = 13,
  kEvaluation = 14,
  kTest = 15,
  kGoal = 20,
  kLocalization = 21,
  kRanges = 22,
  kSlip = 23,
  kPersons = 24,
};

/// Counter-based random numbers (Philox4x32-10, Salmon et al. 2011): the n-th number is a pure function of the key
/// (seed, index, purpose, sub-index) and n, so a stream needs no warm-up, is saved as one counter, and does not
/// depend on which process draws it. Not thread-safe; make one per owner.
class RandomStream {
 public:
  /// `index` is the vehicle, start or layer; `sub` the episode.
  RandomStream(uint64_t seed, RandomPurpose purpose, uint32_t index = 0, uint32_t sub = 0);

  uint32_t NextU32();
  uint64_t NextU64();

  /// Uniform in [0, 1), 53 bits.
  double Uniform();

  /// Uniform in [low, high).
  double Uniform(double low, double high);

  /// Uniform integer in [0, n), n ≥ 1, without modulo bias worth naming (64-bit multiply).
  uint32_t Below(uint32_t n);

  /// Standard normal (Box-Muller, one of the pair; each call takes exactly two draws).
  double Normal();

  /// Number of 32-bit draws made so far; SetPosition restores it.
  uint64_t position() const { return position_; }
  void SetPosition(uint64_t position);

 private:
  void Refill();

  std::array<uint32_t, 2> key_;
  std::array<uint32_t, 2> nonce_;
  uint64_t position_ = 0;
  std::array<uint32_t, 4> block_{};
};

}  // namespace cairn
