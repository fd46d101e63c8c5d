#pragma once

#include <memory>
#include <string>

#include "common/config/experiment.h"
#include "common/roadmap/roadmap_lookup.h"
#include "planner/planner.h"

namespace cairn::deploy {

/// A world with its roadmap and the cost table of its goal.
struct PlannedWorld {
  World world;
  planner::BuiltRoadmap built;
  CostTable table;
  double r_ball = 0;      ///< [m]
  double free_share = 0;  ///< of free space, from which the goal can be reached

  std::shared_ptr<const RoadmapLookup> MakeLookup() const;
};

/// Builds the roadmap that `planner` describes in the experiment's world, as the planner process does. Throws
/// UsageError for what the planner refuses.
PlannedWorld PlanWorld(const Experiment& experiment, const PlannerConfig& planner);

/// Throws UsageError naming --html when there is a file for --svg, which draws plane worlds, and the world is in space.
void CheckSvg(const std::string& svg, const Experiment& experiment);

}  // namespace cairn::deploy
