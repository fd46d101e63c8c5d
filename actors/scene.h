#pragma once

#include <memory>
#include <optional>

#include "actors/cost_starts.h"
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

/// A world with a goal: field, obstacles, cost table, start sets. What is large is shared by its copies. Immutable but
/// for SetTable, which no other thread may call or overlap.
class Scene {
 public:
  /// Builds world, field and obstacles from the experiment; throws UsageError as MakeWorld and Reachability do, and for
  /// a vehicle that drives in a world in space or flies in a plane one.
  explicit Scene(Experiment experiment);
  /// Cheap: the world is shared.
  Scene(const Scene&) = default;
  Scene& operator=(const Scene&) = default;

  /// The scene of evaluation episodes: with the obstacles of the world's evaluation variant (closed doors, unseen
  /// obstacles; common/world/world_variants.h), else the same, the table as it is now included. Cheap.
  static std::shared_ptr<const Scene> ForEvaluation(const std::shared_ptr<const Scene>& scene);

  /// The cost table that rewards and look-ahead read from now on. The scale of D_min in the observation is fixed by
  /// the first table.
  void SetTable(std::shared_ptr<const RoadmapLookup> lookup);

  /// Goal `index` of a set, somewhere in the free space from which the world's own goal is reached: a region as large
  /// as world.goal_tolerance where there is room, depending on world.seed alone.
  Box DrawGoal(StartSet set, int index) const;

  /// The same scene with this goal and its table; `scale` as in d_min_scale(). Cheap.
  Scene WithGoal(const Box& goal, std::shared_ptr<const RoadmapLookup> lookup, double scale) const;

  /// Uniform pose in free space (the largest footprint's circumscribed radius + 3 mm · radius/43 mm from obstacles,
  /// outside the goal, goal reachable; with goals = ANY at least world.goal_distance away where a thousand draws find
  /// such a place), or in the start region, or spread over the table's cost-to-go; yaw uniform, 0 for a vehicle that
  /// keeps it. Training: from (seed, vehicle, kStart, episode), and the table where environment.start is COST_TO_GO or
  /// goals = ANY. Throws UsageError when a million draws find none.
  Pose TrainingStart(int vehicle, int episode) const;

  /// Start `index` of a fixed evaluation set: uniform over free space whatever environment.start says; of all seeds it
  /// depends on world.seed alone. The sets are disjoint. Only of a scene ForEvaluation do they avoid what stands there.
  Pose EvaluationStart(StartSet set, int index) const;

  const Experiment& experiment() const { return experiment_; }
  /// Physics steps in one control step: control_period · physics_rate_hz, rounded, at least 1.
  int control_physics_steps() const { return control_physics_steps_; }
  /// World, field and obstacles as the episodes of this scene meet them.
  const World& world() const { return site_->world; }
  /// The world's own or that of WithGoal.
  const Box& goal() const { return goal_; }
  const DistanceField& field() const { return site_->field; }
  /// Of a plane world.
  const ObstacleGrid& obstacles() const { return *site_->obstacles; }
  /// Of a world in space.
  const SpaceObstacles& space_obstacles() const { return *site_->space_obstacles; }
  /// The field of what the planner was told: what lines of sight to the roadmap are judged by.
  const DistanceField& known_field() const { return known_site_->field; }
  /// Range [m] from p along a unit vector to what the planner was told of, at most `max_range`.
  double CastKnownRay(const Vector3d& p, const Vector3d& direction, double max_range) const {
    return known_site_->CastRay(p, direction, max_range);
  }
  /// Whether the footprint comes within a thousandth of its circumscribed radius of what the planner was told of.
  bool TouchesKnown(const Motion& motion) const;
  const Footprint& footprint() const { return footprint_; }
  bool has_table() const { return lookup_ != nullptr; }
  const RoadmapLookup& lookup() const { return *lookup_; }
  std::shared_ptr<const RoadmapLookup> shared_lookup() const { return lookup_; }
  /// The scale that a first table gives [m]: its longest finite cost-to-go, at least r_ball.
  static double ScaleOf(const RoadmapLookup& lookup);
  /// Longest finite cost-to-go [m] of the first table, or as WithGoal has it: the scale of D_min in the observation.
  double d_min_scale() const { return d_min_scale_; }

 private:
  // One variant of the world, with what answers questions about it.
  struct Site {
    Site(const World& w, const Experiment& experiment, double reach);
    double CastRay(const Vector3d& p, const Vector3d& direction, double max_range) const;
    World world;
    DistanceField field;
    std::optional<ObstacleGrid> obstacles;
    std::optional<SpaceObstacles> space_obstacles;
    Reachability reachability;
  };

  // The first of the points that a vehicle may start from; `region` is where they are, for the error.
  template <typename DrawPoint>
  Pose DrawStart(RandomStream& random, const Box& region, const DrawPoint& draw_point) const;
  const Box& StartSpace() const;
  Pose DrawStartIn(RandomStream& random, const Box& region) const;
  bool TooNear(const Vector3d& p, int draw) const;
  [[noreturn]] void ThrowNoRoom(const char* what, double clearance, const Box& region) const;

  Experiment experiment_;
  int control_physics_steps_;
  Footprint footprint_;
  Box goal_;
  std::shared_ptr<const Site> site_, known_site_, evaluation_site_;
  std::shared_ptr<const RoadmapLookup> lookup_;
  std::shared_ptr<const CostStarts> cost_starts_;  // of lookup_, with environment.start = COST_TO_GO
  double d_min_scale_ = 0;
};

}  // namespace cairn::actors
