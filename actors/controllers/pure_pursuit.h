#pragma once

#include <memory>

#include "actors/controllers/controller.h"
#include "actors/scene.h"

namespace cairn::actors {

/// Gains of the referee, in circumscribed radii R and top speeds V, so that one set fits every vehicle. For the
/// paper's car (R 43 mm, V 1 m/s): planning radius 0.047 m, clearance 0.035 m, look-ahead 0.06 m, 0.7 m/s,
/// 0.08 m/s, 4 /s.
struct PurePursuitParams {
  double planning_radius = 1.09;   ///< inflation of obstacles for its roadmap [R]
  double clearance = 0.81;         ///< of the straight line to the entry vertex [R]
  double look_ahead = 1.40;        ///< distance of the pursued point along the roadmap [R]
  double turn_angle = 0.5;         ///< heading error above which it turns in place [rad]
  double turn_time = 0.2;          ///< time constant of turning in place [s]
  double cruise_speed = 0.7;       ///< [V], times the cosine of the heading error
  double creep_speed = 0.08;       ///< lower bound near obstacles ahead [V]
  double approach_distance = 5.8;  ///< front clearance at which obstacles ahead stop mattering [R per V]
};

/// Pure pursuit along a roadmap of its own (Coulter 1992): the baseline that needs no learning, at its best, since a
/// weak referee is worth nothing. MEASURED, section 5.
class PurePursuit final : public Controller {
 public:
  /// `scene` holds the table of the roadmap built with `Planner(experiment)`; it need not be the environments' own.
  explicit PurePursuit(std::shared_ptr<const Scene> scene, const PurePursuitParams& params = {});

  /// The experiment's planner with the referee's own inflation.
  static PlannerConfig Planner(const Experiment& experiment, const PurePursuitParams& params = {});

  void Act(std::span<const Environment* const> environments, float* actions) override;

  /// Forward speed [m/s] and yaw rate [rad/s] at a pose; stands still where no roadmap leads on.
  void Drive(const Pose& pose, double& speed, double& yaw_rate) const;

 private:
  double FrontClearance(const Pose& pose) const;

  std::shared_ptr<const Scene> scene_;
  PurePursuitParams params_;
  double radius_;
};

}  // namespace cairn::actors
