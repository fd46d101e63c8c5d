#include "actors/controllers/pure_pursuit.h"

#include <algorithm>
#include <cmath>

#include "actors/command.h"
#include "common/core/check.h"

namespace cairn::actors {

PurePursuit::PurePursuit(std::shared_ptr<const Scene> scene, const PurePursuitParams& params)
    : scene_(std::move(scene)), params_(params), radius_(scene_->experiment().vehicle.circumscribed_radius()) {
  CAIRN_CHECK(scene_->has_table());
}

PurePursuit::PurePursuit(const std::shared_ptr<const Scene>& scene, Course::FindTable find_table,
                         const PurePursuitParams& params)
    : PurePursuit(scene, params) {
  find_table_ = std::move(find_table);
}

PlannerConfig PurePursuit::Planner(const Experiment& experiment, const PurePursuitParams& params) {
  PlannerConfig planner = experiment.planner;
  planner.kind = PlannerConfig::Kind::kRrg;  // the same referee whatever rewards the policy
  planner.roadmap.clear();
  planner.radius = params.planning_radius * experiment.vehicle.circumscribed_radius();
  planner.min_spacing = std::min(params.min_spacing * experiment.vehicle.circumscribed_radius(), planner.r_ball());
  return planner;
}

// Free way ahead of the bumper: the shortest of three rays along the heading, from the middle and both flanks [m].
double PurePursuit::FrontClearance(const Senses& senses) const {
  const VehicleConfig& vehicle = scene_->experiment().vehicle;
  const Pose& pose = senses.actual;
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  double range = params_.approach_distance * radius_ + 0.5 * vehicle.length;
  for (const double side : {0.0, 0.5 * vehicle.width, -0.5 * vehicle.width}) {
    range = std::min(range, senses.ranges.Range({pose.x - s * side, pose.y + c * side, pose.z}, {c, s, 0}, range));
  }
  return std::max(0.0, range - 0.5 * vehicle.length);
}

// Free way of the footprint's circle from the centre along a unit vector of the body's level frame [m].
double PurePursuit::FreeRange(const Senses& senses, const Vector3d& direction) const {
  const double range = radius_ + scene_->experiment().vehicle.max_speed * params_.stop_time;
  const Pose& pose = senses.actual;
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  const Vector3d in_world(c * direction.x() - s * direction.y(), s * direction.x() + c * direction.y(), direction.z());
  return std::max(0.0, senses.ranges.Range({pose.x, pose.y, pose.z}, in_world, range) - radius_);
}

VehicleCommand PurePursuit::DriveAlongAxes(const Senses& senses, const Vector3d& gap) const {
  const double distance = gap.norm();
  if (distance == 0) return {};
  const double c = std::cos(senses.believed.yaw), s = std::sin(senses.believed.yaw);
  const Vector3d direction = Vector3d(c * gap.x() + s * gap.y(), c * gap.y() - s * gap.x(), gap.z()) / distance;
  const double top = scene_->experiment().vehicle.max_speed;
  const double approach = FreeRange(senses, direction) / params_.stop_time;
  const double speed = std::min(params_.cruise_speed * top, std::max(params_.axes_creep_speed * top, approach));
  VehicleCommand command{speed * direction.x(), speed * direction.y(), 0};
  if (!scene_->experiment().vehicle.turns()) command[2] = speed * direction.z();
  return command;
}

VehicleCommand PurePursuit::DriveCar(const Senses& senses, const Vector3d& gap) const {
  const VehicleConfig& vehicle = scene_->experiment().vehicle;
  const bool steers = vehicle.kind == VehicleConfig::Kind::kAckermann;
  const double angle = std::remainder(std::atan2(gap.y(), gap.x()) - senses.believed.yaw, 2 * M_PI);
  const double limit = vehicle.max_yaw_rate;
  const double front = FrontClearance(senses);
  const bool blocked = front < params_.blocked_distance * radius_;
  if (!steers && std::abs(angle) > (blocked ? params_.blocked_angle : params_.turn_angle)) {
    return {0, std::clamp(angle / params_.turn_time, -limit, limit)};
  }
  // The circle through p along the heading and through the pursued point: curvature 2 sin(angle) / distance.
  const double curvature = 2 * std::sin(angle) / std::max(gap.norm(), 1e-3 * radius_);
  const double top = vehicle.max_speed;
  const double creep = params_.creep_speed * top;
  const double approach = std::max(creep, top * front / (params_.approach_distance * radius_));
  const double cruise = params_.cruise_speed * top * std::cos(angle);
  if (steers) {
    const double end = vehicle.max_steering;
    const double steering = std::abs(angle) > 0.5 * M_PI
                                ? std::copysign(end, angle)
                                : std::clamp(std::atan(curvature * vehicle.wheel_base), -end, end);
    return {std::min(std::max(creep, cruise), approach), steering};
  }
  const double speed = std::min({cruise, approach, limit / std::max(std::abs(curvature), 1e-9)});
  return {speed, std::clamp(speed * curvature, -limit, limit)};
}

VehicleCommand PurePursuit::Drive(const Pose& pose) const {
  RangeFinder ranges(*scene_);
  return Drive(pose, pose, ranges);
}

VehicleCommand PurePursuit::Drive(const Pose& believed, const Pose& actual, RangeFinder& ranges) const {
  const Vector3d p(believed.x, believed.y, believed.z);
  const int entry = scene_->lookup().EntryVertex(p, scene_->known_field(), params_.clearance * radius_);
  if (entry < 0) return {};
  const Vector3d gap = scene_->lookup().PointAlong(p, entry, params_.look_ahead * radius_) - p;
  const Senses senses{believed, actual, ranges};
  return scene_->experiment().vehicle.holonomic() ? DriveAlongAxes(senses, gap) : DriveCar(senses, gap);
}

void PurePursuit::Act(std::span<const Environment* const> environments, float* actions) {
  const VehicleConfig vehicle = scene_->experiment().vehicle;
  for (const Environment* environment : environments) {
    if (find_table_) {
      const Scene& met = environment->scene();
      const WorldGoal goal(met.experiment().world.seed, met.goal(), met.lookup().table().marks);
      scene_ = std::make_shared<const Scene>(met.WithGoal(met.goal(), find_table_(goal), met.d_min_scale()));
    }
    RangeFinder ranges = environment->Look();
    ToAction(vehicle, Drive(environment->believed_pose(), environment->pose(), ranges), actions);
    actions += vehicle.action_size();
  }
}

}  // namespace cairn::actors
