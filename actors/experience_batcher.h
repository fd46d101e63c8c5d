#pragma once

#include <vector>

#include "common/bus/messages.h"

namespace cairn::actors {

/// A vehicle as it stands after `steps` transitions since the run's start (Rollout::SaveVehicle).
struct SavedVehicle {
  int32_t vehicle = 0;
  int64_t steps = 0;
  Bytes state;
};

/// Packs episode results, then vehicles' states, then segments, into as few messages as fit `max_bytes` each (encoded,
/// without trailer), in the order given. Results go first because a diverged episode has no last segment: the learner
/// must hear of its end before the next episode's first segment; states come before the segments that complete their
/// round. A segment that is too long for one message is split into pieces that continue each other; the observation at
/// a seam stands in both; so are states. Sequence numbers and times are the caller's.
std::vector<Experience> PackExperience(std::vector<Segment> segments, const std::vector<EpisodeResult>& episodes,
                                       const std::vector<SavedVehicle>& states, int observation_size, int action_size,
                                       int max_bytes);

}  // namespace cairn::actors
