#pragma once

#include "common/core/random.h"
#include "common/rl/episode.h"

namespace cairn::actors {

/// What an environment draws random numbers for within an episode.
enum class NoiseUse : uint32_t { kDisturbance = 0, kObservation = 1, kParameters = 2 };

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
  const RandomPurpose purpose = use == NoiseUse::kDisturbance   ? RandomPurpose::kDisturbance
                                : use == NoiseUse::kObservation ? RandomPurpose::kObservationNoise
                                                                : RandomPurpose::kParameters;
  return {seed, purpose, index, sub};
}

}  // namespace cairn::actors
