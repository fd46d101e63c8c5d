#pragma once

#include <memory>

#include "common/bus/goal_table_client.h"
#include "common/bus/lru_map.h"
#include "common/config/experiment.h"
#include "common/roadmap/roadmap_lookup.h"

namespace cairn::actors {

/// The planner's tables of any goal, ready to be read: those used last are kept, up to planner.table_cache_mb. One
/// thread, the one that polls the bus.
class GoalTables {
 public:
  /// Subscribes to the tables plane.
  GoalTables(Bus* bus, const Experiment& experiment, uint64_t experiment_hash);

  /// nullptr while it is on its way. Throws UsageError for a goal for which the planner has no table: a new
  /// process would draw it again.
  std::shared_ptr<const RoadmapLookup> Find(const WorldGoal& goal);

  /// Whether something is on its way.
  bool waiting() const { return !client_.idle(); }

  void Poll(TimePoint now) { client_.Poll(now); }

 private:
  void Add(const WorldGoal& goal, const Roadmap& positions, CostTable table);

  double r_ball_, goal_tolerance_, coverage_;  // of the experiment
  LruMap<WorldGoal, std::shared_ptr<const RoadmapLookup>, WorldGoalHash> tables_;
  GoalTableClient client_;
};

}  // namespace cairn::actors
