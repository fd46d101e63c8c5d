#include "deploy/launcher/local_tables.h"

#include <mutex>

#include "planner/world_planner.h"

namespace cairn::deploy {
namespace {

class LocalTables {
 public:
  explicit LocalTables(const Experiment& experiment)
      : planner_(experiment),
        r_ball_(experiment.planner.r_ball()),
        kept_(static_cast<size_t>(experiment.planner.table_cache_mb) << 20) {}

  std::shared_ptr<const RoadmapLookup> Find(const WorldGoal& goal) {
    const std::lock_guard lock(mutex_);
    if (const auto* known = kept_.Find(goal)) return *known;
    const Roadmap& roadmap = planner_.Site(goal.world_seed).built.roadmap;
    auto table = std::make_shared<const RoadmapLookup>(roadmap.dimension, roadmap.positions,
                                                       planner_.Table(goal.world_seed, goal.box(), goal.marks), r_ball_,
                                                       roadmap.num_bends);
    const size_t bytes = table->num_bytes();
    return *kept_.Insert(goal, std::move(table), bytes);
  }

 private:
  std::mutex mutex_;  // guards all below
  planner::WorldPlanner planner_;
  double r_ball_;
  LruMap<WorldGoal, std::shared_ptr<const RoadmapLookup>, WorldGoalHash> kept_;
};

}  // namespace

actors::Course::FindTable MakeLocalTables(const Experiment& experiment) {
  const bool repair = experiment.planner.repair != PlannerConfig::Repair::kNone;
  if (experiment.goals == Goals::kWorld && !repair) return {};
  return [tables = std::make_shared<LocalTables>(experiment)](const WorldGoal& goal) { return tables->Find(goal); };
}

std::shared_ptr<actors::Course> MakeLocalCourse(const std::shared_ptr<const actors::Scene>& scene) {
  return std::make_shared<actors::Course>(scene, MakeLocalTables(scene->experiment()));
}

}  // namespace cairn::deploy
