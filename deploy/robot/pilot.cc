#include "deploy/robot/pilot.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "actors/command.h"
#include "actors/range_finder.h"
#include "common/core/check.h"

namespace cairn::deploy {
namespace {

using actors::Motion;
using actors::Pose;
using actors::VehicleCommand;

constexpr int kHeldPeriods = 3;  // two states may be lost before the robot stops by itself

double WrapAngle(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

Motion ToMotion(const RobotState& state, int dimension) {
  const auto& [x, y, z, yaw] = state.pose;
  const auto& [vx, vy, vz, yaw_rate] = state.velocity;
  const bool flies = dimension == 3;
  return {x, y, flies ? z : 0, yaw, vx, vy, flies ? vz : 0, yaw_rate};
}

// Where it is after `dt` [s] at the mean of two velocities.
Pose Advance(const Motion& from, const Motion& now, double dt) {
  const double vx = 0.5 * (from.vx + now.vx), vy = 0.5 * (from.vy + now.vy), vz = 0.5 * (from.vz + now.vz);
  const double turn = 0.5 * (from.yaw_rate + now.yaw_rate) * dt;
  const double c = std::cos(from.yaw + 0.5 * turn), s = std::sin(from.yaw + 0.5 * turn);
  return {from.x + (c * vx - s * vy) * dt, from.y + (s * vx + c * vy) * dt, from.yaw + turn, from.z + vz * dt};
}

// The way from `a` to `b` but for a share of it.
Pose Mix(const Pose& a, const Pose& b, double share_of_a) {
  const double t = 1 - share_of_a;
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.yaw + t * WrapAngle(b.yaw - a.yaw), a.z + t * (b.z - a.z)};
}

std::string NotFinite(const char* field, std::span<const double> values) {
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) return fmt::format("{}[{}] is {}; it must be finite", field, i, values[i]);
  }
  return "";
}

}  // namespace

Pilot::Pilot(std::shared_ptr<const actors::Scene> scene, const PolicyFile& policy)
    : scene_(std::move(scene)),
      policy_(policy.shape, 1),
      builder_(*scene_),
      reward_(actors::MakeReward(scene_->experiment())),
      scan_(scene_->experiment().vehicle),
      last_actions_(static_cast<size_t>(scene_->experiment().observation.last_actions) *
                    static_cast<size_t>(policy.shape.action_size)),
      observation_(static_cast<size_t>(builder_.size())),
      action_(static_cast<size_t>(policy.shape.action_size)) {
  CAIRN_CHECK(policy.shape.observation_size == builder_.size() && scene_->has_table());
  policy_.SetParameters(policy.parameters);
  const Experiment& experiment = scene_->experiment();
  if (experiment.safety.filter == SafetyConfig::Filter::kOff) return;
  filter_.emplace(*scene_);
  EnvironmentConfig exact = experiment.environment;
  exact.parameter_spread = 0;
  twin_ = actors::MakeVehicle(experiment.vehicle, exact);
}

Experiment Pilot::ForPilot(Experiment experiment) {
  if (experiment.safety.filter == SafetyConfig::Filter::kOff) return experiment;
  if (experiment.vehicle.dimension() == 3) {
    ThrowUsageError(
        "safety.filter: a robot that flies sends {} ranges, too few for it; drive with --set safety.filter=OFF",
        experiment.vehicle.scan.beams);
  }
  experiment.safety.period = experiment.environment.control_period;
  return experiment;
}

double Pilot::validity() const { return kHeldPeriods * scene_->experiment().environment.control_period; }

RobotCommand Pilot::Stop(const std::string& note) const {
  const VehicleConfig& vehicle = scene_->experiment().vehicle;
  const VehicleCommand rest = actors::RestCommand(vehicle);
  RobotCommand command;
  command.valid = validity();
  command.command.assign(rest.begin(), rest.begin() + vehicle.action_size());
  command.note = note;
  return command;
}

std::string Pilot::Fault(const RobotState& state) const {
  for (std::string fault : {NotFinite("pose", state.pose), NotFinite("velocity", state.velocity)}) {
    if (!fault.empty()) return fault;
  }
  if (belief_ && state.utime <= belief_->utime) {
    return fmt::format("utime is {}, not later than the last state's {}; do two robots send on this channel?",
                       state.utime, belief_->utime);
  }
  if (const double widest = 2 * std::numbers::pi / scene_->experiment().safety.beams;
      filter_ && state.angle_step > widest * (1 + 1e-6)) {
    return fmt::format("angle_step is {:.4g}; the safety filter (safety.beams = {}) wants {:.4g} rad or less",
                       state.angle_step, scene_->experiment().safety.beams, widest);
  }
  const Vector3d p(state.pose[0], state.pose[1], scene_->world().dimension == 3 ? state.pose[2] : 0);
  if (!scene_->world().Contains(scene_->world().bounds, p)) {
    return fmt::format("the robot is at {:.3f}, {:.3f}, {:.3f}, outside the world", p.x(), p.y(), p.z());
  }
  if (scene_->known_field().Distance(p) <= 0) {
    return fmt::format("the robot is at {:.3f}, {:.3f}, {:.3f}, inside an obstacle of the map", p.x(), p.y(), p.z());
  }
  return "";
}

// The measured pose, or with observation.pose_filter what a complementary filter makes of it and of the velocities.
Pose Pilot::Believe(const Motion& measured, int64_t utime) {
  const double share = scene_->experiment().observation.pose_filter;
  Pose pose = measured.pose();
  if (share > 0 && belief_) {
    const double dt = 1e-6 * static_cast<double>(utime - belief_->utime);
    pose = Mix(Advance(belief_->motion, measured, dt), pose, share);
  }
  belief_ = Belief{measured, utime};
  Motion& motion = belief_->motion;
  motion.x = pose.x, motion.y = pose.y, motion.z = pose.z, motion.yaw = pose.yaw;
  return pose;
}

RobotCommand Pilot::Act(const RobotState& state) {
  std::string fault = Fault(state);
  const Motion motion = ToMotion(state, scene_->world().dimension);
  if (fault.empty()) fault = scan_.Set(motion, state.angle_min, state.angle_step, state.ranges);
  RobotCommand command = Stop(fault);
  command.state_utime = state.utime;
  if (!fault.empty()) {
    if (twin_) twin_->Command(actors::RestCommand(scene_->experiment().vehicle));  // as the robot is told
    return command;
  }

  const Pose believed = Believe(motion, state.utime);
  const Vector3d p(believed.x, believed.y, believed.z);
  const float distance = reward_->Distance(*scene_, p);
  if (scene_->world().Contains(scene_->goal(), p)) {
    command.mode = RobotCommand::Mode::kArrived;
    command.way_to_go = 0;
    command.note = "arrived";
    return command;
  }
  MoveTwin(state.utime);
  command.mode = RobotCommand::Mode::kDrive;
  command.way_to_go = std::isfinite(distance) ? distance : -1;
  command.command = Drive(motion, believed, distance);
  return command;
}

std::vector<double> Pilot::Drive(const Motion& motion, const Pose& believed, float distance) {
  d_min_ = std::min(d_min_, distance);
  actors::RangeFinder ranges(*scene_, scan_);
  builder_.Build(motion, believed, d_min_, ranges, last_actions_, observation_.data());
  policy_.Act(observation_.data(), 1, action_.data());
  if (!last_actions_.empty()) {
    std::copy_backward(last_actions_.begin(), last_actions_.end() - static_cast<ptrdiff_t>(action_.size()),
                       last_actions_.end());
    std::copy(action_.begin(), action_.end(), last_actions_.begin());
  }
  VehicleCommand command = actors::ToCommand(scene_->experiment().vehicle, action_.data());
  if (filter_) command = Filter(command, motion);
  return {command.begin(), command.begin() + static_cast<ptrdiff_t>(action_.size())};
}

// The twin goes on with its last command up to this state; after a gap in which the robot has stopped by itself it
// stands.
void Pilot::MoveTwin(int64_t utime) {
  if (!filter_) return;
  const double dt = 1e-6 * static_cast<double>(utime - twin_utime_);
  if (twin_utime_ == 0 || dt > validity()) {
    RandomStream exact(0, RandomPurpose::kParameters);
    twin_->Reset({}, exact);
    filter_->Reset();
    twin_steps_ = 0;
  } else {
    const auto steps = std::lround(dt * scene_->experiment().environment.physics_rate_hz);
    for (int64_t i = 0; i < steps; ++i) twin_->Step();
    twin_steps_ += steps;
  }
  twin_utime_ = utime;
}

VehicleCommand Pilot::Filter(const VehicleCommand& command, const Motion& motion) {
  actors::RangeFinder ranges(*scene_, scan_);
  const double nearest = std::max(0.0, scan_.nearest() - std::abs(scene_->experiment().vehicle.scan.mount_x));
  const VehicleCommand safe = filter_->Apply({command, *twin_, motion, nearest, twin_steps_}, ranges);
  num_filtered_ += filter_->changed() ? 1 : 0;
  twin_->Command(safe);
  return safe;
}

}  // namespace cairn::deploy
