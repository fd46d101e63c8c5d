#include "actors/goal_tables.h"

#include "common/core/check.h"

namespace cairn::actors {

GoalTables::GoalTables(Bus* bus, const Experiment& experiment, uint64_t experiment_hash)
    : r_ball_(experiment.planner.r_ball()),
      goal_tolerance_(experiment.world.goal_tolerance),
      coverage_(experiment.planner.coverage),
      tables_(static_cast<size_t>(experiment.planner.table_cache_mb) << 20),
      client_(bus, experiment_hash, [this](const WorldGoal& goal, const Roadmap& positions, CostTable table) {
        Add(goal, positions, std::move(table));
      }) {}

std::shared_ptr<const RoadmapLookup> GoalTables::Find(const WorldGoal& goal) {
  const auto* known = tables_.Find(goal);
  if (known == nullptr) {
    client_.Want(goal);
    return nullptr;
  }
  if (*known == nullptr) {
    ThrowUsageError(
        "world.goal_tolerance = {} m: the planner has no table for the goal ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, "
        "{:.4g}, {:.4g}) m of world {}: no vertex lies in it or within r_ball = eta / 2; a larger tolerance or "
        "planner.coverage, {}, leaves no goal without one",
        goal_tolerance_, goal.min[0], goal.min[1], goal.min[2], goal.max[0], goal.max[1], goal.max[2], goal.world_seed,
        coverage_);
  }
  return *known;
}

void GoalTables::Add(const WorldGoal& goal, const Roadmap& positions, CostTable table) {
  std::shared_ptr<const RoadmapLookup> lookup;
  if (!table.cost.empty()) {
    lookup = std::make_shared<RoadmapLookup>(positions.dimension, positions.positions, std::move(table), r_ball_,
                                             positions.num_bends);
  }
  const size_t bytes = lookup == nullptr ? sizeof(goal) : lookup->num_bytes();
  tables_.Insert(goal, std::move(lookup), bytes);
}

}  // namespace cairn::actors
