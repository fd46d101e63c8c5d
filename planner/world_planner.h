#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "common/config/experiment.h"
#include "planner/planner.h"

namespace cairn::planner {

/// A world as the planner knows it, with its roadmap.
struct PlannedSite {
  World world;
  BuiltRoadmap built;
};

/// The roadmaps of an experiment's worlds, each built when it is asked for first, and cost tables of any goal in them.
/// What it gives depends on the experiment alone. One thread.
class WorldPlanner {
 public:
  explicit WorldPlanner(Experiment experiment) : experiment_(std::move(experiment)) {}

  /// The world of this seed; holds as long as the planner. Throws UsageError when it is none of the experiment's
  /// (world.seed, training_worlds, unseen_worlds) and as BuildRoadmap does.
  const PlannedSite& Site(uint64_t world_seed);
  /// The experiment's own world.
  const PlannedSite& Home() { return Site(experiment_.world.seed); }

  /// Costs to a region, or to a point (min = max): where no vertex lies in it those within r_ball of it have cost 0, as
  /// near as costs are read anyway. Throws UsageError as Site does, and when there are none.
  CostTable Table(uint64_t world_seed, const Box& goal);

  /// The same around marked obstacles ([3 × number], middles in W [m]): without the edges that come nearer to one than
  /// planner.radius + planner.repair_mark_radius. The positions stay those of the roadmap.
  CostTable Table(uint64_t world_seed, const Box& goal, const std::vector<float>& marks);

  /// Builds the next roadmap that nobody has asked for yet; false when there is none left.
  bool BuildAhead();

 private:
  bool Knows(uint64_t world_seed) const;
  CostTable Table(const World& world, const Roadmap& roadmap, const Box& goal) const;

  Experiment experiment_;
  std::map<uint64_t, PlannedSite> sites_;  // by seed
};

}  // namespace cairn::planner
