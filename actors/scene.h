#pragma once

#include <memory>
#include <optional>

#include "actors/motion.h"
#include "common/config/experiment.h"
#include "common/core/random.h"
#include "common/rl/episode.h"
#include "common/roadmap/roadmap_lookup.h"
#include "common/world/distance_field.h"
#include "common/world/obstacle_grid.h"
#include "common/world/reachability.h"
#include "common/world/space_obstacles.h"
#include "common/world/world.h"

namespace cairn::actors {

/// Everything that the environments of one process share: world, field, obstacles, cost table, start sets. Immutable
/// but for SetTable, which no other thread may call or overlap.
class Scene {
 public:
  /// Builds world, field and obstacles from the experiment; throws UsageError as MakeWorld and Reachability do, and for
  /// a vehicle that drives in a world in space or flies in a plane one.
  explicit Scene(Experiment experiment);
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// The cost table that rewards and look-ahead read from now on. The scale of D_min in the observation is fixed by
  /// the first table.
  void SetTable(std::shared_ptr<const RoadmapLookup> lookup);

  /// Uniform pose in free space (circumscribed radius + 3 mm · radius/43 mm from obstacles, outside the goal, goal
  /// reachable), or in the start region; yaw uniform, 0 for a vehicle that keeps it. Training: from (seed, vehicle,
  /// kStart, episode). Throws UsageError when a million draws find none.
  Pose TrainingStart(int vehicle, int episode) const;

  /// Start `index` of a fixed evaluation set: uniform over free space whatever environment.start says; of all seeds it
  /// depends on world.seed alone. The sets are disjoint.
  Pose EvaluationStart(StartSet set, int index) const;

  const Experiment& experiment() const { return experiment_; }
  /// Physics steps in one control step: control_period · physics_rate_hz, rounded, at least 1.
  int control_physics_steps() const { return control_physics_steps_; }
  const World& world() const { return world_; }
  const DistanceField& field() const { return field_; }
  /// Of a plane world.
  const ObstacleGrid& obstacles() const { return *obstacles_; }
  /// Of a world in space.
  const SpaceObstacles& space_obstacles() const { return *space_obstacles_; }
  const Footprint& footprint() const { return footprint_; }
  bool has_table() const { return lookup_ != nullptr; }
  const RoadmapLookup& lookup() const { return *lookup_; }
  /// Longest finite cost-to-go [m] of the first table: the scale of D_min in the observation.
  double d_min_scale() const { return d_min_scale_; }

 private:
  Pose DrawStart(RandomStream& random, const Box& region) const;

  Experiment experiment_;
  int control_physics_steps_;
  World world_;
  DistanceField field_;
  Footprint footprint_;
  std::optional<ObstacleGrid> obstacles_;
  std::optional<SpaceObstacles> space_obstacles_;
  Reachability reachability_;
  std::shared_ptr<const RoadmapLookup> lookup_;
  double d_min_scale_ = 0;
};

}  // namespace cairn::actors
