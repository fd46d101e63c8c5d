#pragma once

#include <string>

#include "common/config/experiment.h"

namespace cairn::deploy {

/// Compares the published lengths of a Moving AI scenario with the shortest ways on the experiment's map: a point on
/// cells, 8 neighbours, no corner cut. Prints a line for each that differs and a summary, or one JSON object. Returns 1
/// when any differs, else 0; throws UsageError for a scenario of another map, a torn one, a world that is no Moving AI
/// map.
int CheckScenario(const std::string& file, const WorldConfig& world, bool json);

}  // namespace cairn::deploy
