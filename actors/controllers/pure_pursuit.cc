#include "actors/controllers/pure_pursuit.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"

namespace cairn::actors {

PurePursuit::PurePursuit(std::shared_ptr<const Scene> scene, const PurePursuitParams& params)
    : scene_(std::move(scene)), params_(params), radius_(scene_->experiment().vehicle.circumscribed_radius()) {
  CAIRN_CHECK(scene_->has_table());
}

PlannerConfig PurePursuit::Planner(const Experiment& experiment, const PurePursuitParams& params) {
  PlannerConfig planner = experiment.planner;
  planner.radius = params.planning_radius * experiment.vehicle.circumscribed_radius();
  planner.min_spacing = params.min_spacing * experiment.vehicle.circumscribed_radius();
  return planner;
}

// Free way ahead of the bumper: the shortest of three rays along the heading, from the middle and both flanks [m].
double PurePursuit::FrontClearance(const Pose& pose) const {
  const VehicleConfig& vehicle = scene_->experiment().vehicle;
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  double range = params_.approach_distance * radius_ + 0.5 * vehicle.length;
  for (const double side : {0.0, 0.5 * vehicle.width, -0.5 * vehicle.width}) {
    range = std::min(range, scene_->obstacles().CastRay(pose.x - s * side, pose.y + c * side, c, s, range));
  }
  return std::max(0.0, range - 0.5 * vehicle.length);
}

void PurePursuit::Drive(const Pose& pose, double& speed, double& yaw_rate) const {
  speed = yaw_rate = 0;
  const VehicleConfig& vehicle = scene_->experiment().vehicle;
  const Vector3d p(pose.x, pose.y, 0);
  const int entry = scene_->lookup().EntryVertex(p, scene_->field(), params_.clearance * radius_);
  if (entry < 0) return;
  const Vector3d gap = scene_->lookup().PointAlong(p, entry, params_.look_ahead * radius_) - p;
  const double angle = std::remainder(std::atan2(gap.y(), gap.x()) - pose.yaw, 2 * M_PI);
  const double limit = vehicle.max_yaw_rate;
  const double front = FrontClearance(pose);
  const bool blocked = front < params_.blocked_distance * radius_;
  if (std::abs(angle) > (blocked ? params_.blocked_angle : params_.turn_angle)) {
    yaw_rate = std::clamp(angle / params_.turn_time, -limit, limit);
    return;
  }
  // The circle through p along the heading and through the pursued point: curvature 2 sin(angle) / distance.
  const double curvature = 2 * std::sin(angle) / std::max(gap.norm(), 1e-3 * radius_);
  const double top = vehicle.max_speed;
  const double approach = top * front / (params_.approach_distance * radius_);
  speed = std::min({params_.cruise_speed * top * std::cos(angle), std::max(params_.creep_speed * top, approach),
                    limit / std::max(std::abs(curvature), 1e-9)});
  yaw_rate = std::clamp(speed * curvature, -limit, limit);
}

void PurePursuit::Act(std::span<const Environment* const> environments, float* actions) {
  const VehicleConfig& vehicle = scene_->experiment().vehicle;
  for (const Environment* environment : environments) {
    double speed = 0, yaw_rate = 0;
    Drive(environment->pose(), speed, yaw_rate);
    const double a = 2 * (speed - vehicle.min_speed) / (vehicle.max_speed - vehicle.min_speed) - 1;
    *actions++ = static_cast<float>(std::clamp(a, -1.0, 1.0));
    *actions++ = static_cast<float>(yaw_rate / vehicle.max_yaw_rate);
  }
}

}  // namespace cairn::actors
