#pragma once

#include <vector>

#include "common/bus/messages.h"

namespace cairn::actors {

/// Packs segments and episode results into as few messages as fit `max_bytes` each (encoded, without trailer),
/// in the order given. A segment that is too long for one message is split into pieces that continue each other; the
/// observation at a seam stands in both. Sequence numbers and times are the caller's.
std::vector<Experience> PackExperience(std::vector<Segment> segments, const std::vector<EpisodeResult>& episodes,
                                       int observation_size, int action_size, int max_bytes);

}  // namespace cairn::actors
