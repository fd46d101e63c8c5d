#pragma once

#include <memory>

#include "actors/controllers/controller.h"
#include "actors/course.h"
#include "actors/scene.h"

namespace cairn::actors {

/// Gains of the referee, in circumscribed radii R and top speeds V, so that one set fits every vehicle. MEASURED's (for
/// the paper's car, R 43 mm, V 1 m/s: planning radius 0.047 m, look-ahead 0.06 m, 4 /s of front clearance, spacing
/// 0.05 m) solved 166–188 of 200 on the five mazes tried with our RRG; a finer roadmap farther from the walls, a longer
/// look-ahead, an earlier slow-down and turning on while the way ahead is blocked solve nearly all, faster.
struct PurePursuitParams {
  double planning_radius = 1.35;   ///< inflation of obstacles for its roadmap [R]
  double min_spacing = 0.46;       ///< of its roadmap's vertices [R], at most r_ball
  double clearance = 0.81;         ///< of the straight line to the entry vertex [R]
  double look_ahead = 1.80;        ///< distance of the pursued point along the roadmap [R]
  double turn_angle = 0.5;         ///< heading error above which it turns in place [rad]
  double blocked_angle = 0.1;      ///< the same while an obstacle stands close ahead [rad]
  double blocked_distance = 0.5;   ///< close ahead [R]
  double turn_time = 0.2;          ///< time constant of turning in place [s]
  double cruise_speed = 0.7;       ///< [V], times the cosine of the heading error
  double creep_speed = 0.08;       ///< lower bound near obstacles ahead [V]
  double axes_creep_speed = 0.03;  ///< the same of what moves along axes [V]
  double stop_time = 1.0;  ///< the same would reach the obstacle ahead in [s]; 0.6: 0.875 of the cube, 1.0: 0.975
  double approach_distance = 8.0;  ///< front clearance from which on V would be allowed [R]
};

/// Pure pursuit along a roadmap of its own (Coulter 1992): the baseline that needs no learning, at its best, since a
/// weak referee is worth nothing. MEASURED, section 5.
class PurePursuit final : public Controller {
 public:
  /// `scene` holds the table of the roadmap built with `Planner(experiment)`; it need not be the environments' own.
  explicit PurePursuit(std::shared_ptr<const Scene> scene, const PurePursuitParams& params = {});
  /// With `find_table`, for goals = ANY and repair: it gives the table of the environment's goal around the
  /// environment's marks over the referee's own roadmap, at once.
  PurePursuit(const std::shared_ptr<const Scene>& scene, Course::FindTable find_table,
              const PurePursuitParams& params = {});

  /// The experiment's planner as RRG, whatever it is, with the referee's own inflation and spacing.
  static PlannerConfig Planner(const Experiment& experiment, const PurePursuitParams& params = {});

  void Act(std::span<const Environment* const> environments, float* actions) override;

  /// Commands of a vehicle that takes `believed` for its pose, is at `actual` and sees `ranges`; stands still where no
  /// roadmap leads on. A car turns in place before it drives on; an ACKERMANN car steers at its creeping speed instead;
  /// what moves along all axes heads straight for the pursued point.
  VehicleCommand Drive(const Pose& believed, const Pose& actual, RangeFinder& ranges) const;

  /// The same without noise and people, in its own scene.
  VehicleCommand Drive(const Pose& pose) const;

 private:
  // What a command needs to know besides the way.
  struct Senses {
    const Pose& believed;
    const Pose& actual;
    RangeFinder& ranges;
  };
  VehicleCommand DriveCar(const Senses& senses, const Vector3d& gap) const;
  VehicleCommand DriveAlongAxes(const Senses& senses, const Vector3d& gap) const;
  double FrontClearance(const Senses& senses) const;
  double FreeRange(const Senses& senses, const Vector3d& direction) const;

  std::shared_ptr<const Scene> scene_;  // of the environment that it drives, with its own table
  Course::FindTable find_table_;
  PurePursuitParams params_;
  double radius_;
};

}  // namespace cairn::actors
