#pragma once

#include <string>

namespace cairn::planner {

/// Viridis (van der Walt and Smith 2015) reversed, as "#rrggbb": t = 0 yellow, t = 1 dark purple; even steps in t look
/// even, also in grey and to colour-blind eyes. t is clamped to [0, 1].
std::string CostColor(double t);

}  // namespace cairn::planner
