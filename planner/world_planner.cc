#include "planner/world_planner.h"

#include <algorithm>

#include "common/core/check.h"
#include "common/world/distance_field.h"
#include "common/world/world_variants.h"
#include "planner/repair.h"

namespace cairn::planner {

bool WorldPlanner::Knows(uint64_t world_seed) const {
  return world_seed - experiment_.world.seed < static_cast<uint64_t>(experiment_.world.num_worlds());
}

const PlannedSite& WorldPlanner::Site(uint64_t world_seed) {
  const auto built = sites_.find(world_seed);
  if (built != sites_.end()) return built->second;
  if (!Knows(world_seed)) {
    ThrowUsageError("world {}: this experiment has those of seeds {} to {}", world_seed, experiment_.world.seed,
                    experiment_.world.seed + static_cast<uint64_t>(experiment_.world.num_worlds()) - 1);
  }
  Experiment experiment = experiment_;
  experiment.world.seed = world_seed;
  PlannedSite site{MakeWorldVariants(experiment).known, {}};
  const DistanceField field(site.world, experiment.world.field_resolution);
  site.built = BuildRoadmap(site.world, field, experiment.planner, experiment.vehicle.inscribed_radius());
  return sites_.emplace(world_seed, std::move(site)).first->second;
}

CostTable WorldPlanner::Table(uint64_t world_seed, const Box& goal) {
  const PlannedSite& site = Site(world_seed);
  return Table(site.world, site.built.roadmap, goal);
}

CostTable WorldPlanner::Table(uint64_t world_seed, const Box& goal, const std::vector<float>& marks) {
  if (marks.empty()) return Table(world_seed, goal);
  const PlannedSite& site = Site(world_seed);
  const double reach = experiment_.planner.radius + experiment_.planner.repair_mark_radius;
  Roadmap roadmap = site.built.roadmap;
  std::vector<Box> points;
  for (size_t m = 0; m + 2 < marks.size(); m += 3) {
    const Vector3d p(marks[m], marks[m + 1], marks[m + 2]);
    points.push_back({p, p});
  }
  BlockEdges(points, reach, &roadmap);
  CostTable table = Table(site.world, roadmap, goal);
  table.marks = marks;
  table.mark_reach = static_cast<float>(reach);
  return table;
}

CostTable WorldPlanner::Table(const World& world, const Roadmap& roadmap, const Box& goal) const {
  const auto holds_vertex = [&](const Box& region) {
    for (int v = 0; v < roadmap.num_vertices(); ++v) {
      if (world.Contains(region, roadmap.position(v))) return true;
    }
    return false;
  };
  if (holds_vertex(goal)) return ComputeCostTable(roadmap, world, goal);
  const Vector3d ball = Vector3d::Constant(experiment_.planner.r_ball());
  CostTable table = ComputeCostTable(roadmap, world, {goal.min - ball, goal.max + ball});
  table.goal = goal;
  return table;
}

bool WorldPlanner::BuildAhead() {
  const auto worlds = static_cast<uint64_t>(experiment_.world.num_worlds());
  if (sites_.size() >= worlds) return false;
  for (uint64_t i = 0; i < worlds; ++i) {
    if (sites_.count(experiment_.world.seed + i) > 0) continue;
    Site(experiment_.world.seed + i);
    return true;
  }
  return false;
}

}  // namespace cairn::planner
