#pragma once

#include <vector>

#include "common/rl/episode.h"
#include "common/rl/segment.h"

namespace cairn::learner {

/// What the actors made since it was last asked for.
struct Harvest {
  std::vector<Segment> segments;
  std::vector<EpisodeResult> episodes;  ///< finished training episodes
};

}  // namespace cairn::learner
