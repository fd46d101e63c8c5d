#pragma once

#include <array>

#include "common/rl/episode.h"

namespace cairn::planner {

/// The colour of trajectories that ended in one way, as "#rrggbb".
struct OutcomeStyle {
  Outcome outcome;
  const char* color;
};

/// In the order of legends.
inline constexpr std::array<OutcomeStyle, 5> kOutcomeStyles{{{Outcome::kGoal, "#0b62a4"},
                                                             {Outcome::kCollision, "#d1242f"},
                                                             {Outcome::kTimeout, "#e08700"},
                                                             {Outcome::kDiverged, "#8250df"},
                                                             {Outcome::kRunning, "#6e7781"}}};

}  // namespace cairn::planner
