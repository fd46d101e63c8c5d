#pragma once

#include "common/config/experiment.h"
#include "common/roadmap/roadmap.h"
#include "common/world/distance_field.h"
#include "common/world/world.h"

namespace cairn::planner {

/// Whether r_ball < planner.radius + inscribed_radius [m], which proves that costs are not read through walls however
/// thin.
inline bool NoWallIsTooThin(const PlannerConfig& config, double inscribed_radius) {
  return config.r_ball() < config.radius + inscribed_radius;
}

/// Checks by sampling that costs are not read through walls whose thickness no obstacle tells, those of an imported map
/// or of obstacles that touch: from no free point may the cheapest vertex within r_ball lie out of sight and be cheaper
/// by more than 2 r_ball than what is in sight. Nothing is sampled when NoWallIsTooThin. Throws UsageError with the
/// point and the largest eta that is certain to pass.
void CheckCostsBehindWalls(const World& world, const DistanceField& field, const Roadmap& roadmap,
                           const CostTable& table, const PlannerConfig& config, double inscribed_radius);

}  // namespace cairn::planner
