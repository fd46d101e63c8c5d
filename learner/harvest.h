#pragma once

#include <vector>

#include "common/rl/episode.h"
#include "common/rl/segment.h"
#include "learner/coordinator_state.h"

namespace cairn::learner {

/// What the actors made since it was last asked for.
struct Harvest {
  std::vector<Segment> segments;
  std::vector<EpisodeResult> episodes;  ///< finished training episodes
  /// Books and environments of all vehicles at the end of a round that asked for them; else empty.
  std::vector<VehicleState> vehicles;
};

}  // namespace cairn::learner
