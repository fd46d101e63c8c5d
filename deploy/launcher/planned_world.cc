#include "deploy/launcher/planned_world.h"

#include "common/core/check.h"
#include "common/world/distance_field.h"
#include "common/world/reachability.h"
#include "common/world/world_variants.h"

namespace cairn::deploy {

std::shared_ptr<const RoadmapLookup> PlannedWorld::MakeLookup() const {
  return std::make_shared<RoadmapLookup>(built.roadmap.dimension, built.roadmap.positions, table, r_ball,
                                         built.roadmap.num_bends);
}

PlannedWorld PlanWorld(const Experiment& experiment, const PlannerConfig& planner) {
  PlannedWorld planned;
  planned.world = MakeWorldVariants(experiment).known;
  planned.r_ball = planner.r_ball();
  const DistanceField field(planned.world, experiment.world.field_resolution);
  planned.built = planner::BuildRoadmap(planned.world, field, planner, experiment.vehicle.inscribed_radius());
  planned.free_share = Reachability(planned.world, field, planner.radius).share();
  planned.table = planner::ComputeCostTable(planned.built.roadmap, planned.world, planned.world.goal);
  return planned;
}

void CheckSvg(const std::string& svg, const Experiment& experiment) {
  if (svg.empty() || MakeWorldWithoutGoal(experiment.world).dimension == 2) return;
  ThrowUsageError("--svg {}: draws plane worlds, and {}'s is in space; --html FILE shows it from all sides", svg,
                  experiment.name);
}

}  // namespace cairn::deploy
