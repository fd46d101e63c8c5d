#pragma once

#include <vector>

#include "common/bus/messages.h"

namespace cairn::actors {

/// Packs episode results, then segments, into as few messages as fit `max_bytes` each (encoded, without trailer), in
/// the order given. Results go first because a diverged episode has no last segment: the learner must hear of its end
/// before the next episode's first segment. A segment that is too long for one message is split into pieces that
/// continue each other; the observation at a seam stands in both. Sequence numbers and times are the caller's.
std::vector<Experience> PackExperience(std::vector<Segment> segments, const std::vector<EpisodeResult>& episodes,
                                       int observation_size, int action_size, int max_bytes);

}  // namespace cairn::actors
