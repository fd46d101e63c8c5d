#pragma once

#include "common/core/random.h"
#include "common/rl/episode.h"

namespace cairn::actors {

/// What an environment draws random numbers for within an episode.
enum class NoiseUse : uint32_t {
  kDisturbance = 0,
  kObservation = 1,
  kParameters = 2,
  kLocalization = 3,
  kRanges = 4,
  kSlip = 5,
  kPersons = 6
};

/// The purpose of training episodes' streams.
constexpr RandomPurpose TrainingPurpose(NoiseUse use) {
  constexpr RandomPurpose kPurposes[] = {RandomPurpose::kDisturbance, RandomPurpose::kObservationNoise,
                                         RandomPurpose::kParameters,  RandomPurpose::kLocalization,
                                         RandomPurpose::kRanges,      RandomPurpose::kSlip,
                                         RandomPurpose::kPersons};
  return kPurposes[static_cast<size_t>(use)];
}

/// The stream of an episode, named by its set, vehicle (or start) and episode (or evaluation), never by the process
/// that runs it. Training: (seed, vehicle, purpose, episode). Evaluation has a purpose of its own, whose index packs
/// start (20 bits; at most 100,000 starts), set (4) and use (8).
inline RandomStream EpisodeStream(uint64_t seed, const EpisodeResult& episode, NoiseUse use) {
  const auto index = static_cast<uint32_t>(episode.vehicle);
  const auto sub = static_cast<uint32_t>(episode.episode);
  if (episode.set != StartSet::kTraining) {
    const uint32_t packed = index | static_cast<uint32_t>(episode.set) << 20 | static_cast<uint32_t>(use) << 24;
    return {seed, RandomPurpose::kEvaluation, packed, sub};
  }
  return {seed, TrainingPurpose(use), index, sub};
}

}  // namespace cairn::actors
