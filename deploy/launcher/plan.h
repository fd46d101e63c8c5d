#pragma once

#include <string>
#include <vector>

#include "common/config/load.h"

namespace cairn::deploy {

/// What was typed after `cairn plan`.
struct PlanOptions {
  std::string file;
  std::string svg;   ///< picture to write; empty: none
  std::string html;  ///< interactive page to write; empty: none
  std::string save;  ///< roadmap file to write, for planner.roadmap; empty: none
  std::string scen;  ///< Moving AI scenario to check, in the place of planning; empty: none
  bool json = false;
  std::vector<std::string> overrides;
  PlaceArguments place;  ///< --map, --robot, --goal, --start
};

/// Builds the roadmap and cost table of an experiment, prints what came out and draws it; of a map without a goal, the
/// map alone, with a grid to read one from. The same seed prints the same
/// bytes, but for the build time. With a scenario its check alone, see CheckScenario. Returns the exit code; throws
/// UsageError or Error.
int Plan(const PlanOptions& options);

}  // namespace cairn::deploy
