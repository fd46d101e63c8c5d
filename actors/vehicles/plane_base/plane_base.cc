#include "actors/vehicles/plane_base/plane_base.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn::actors {
namespace {

using Kind = VehicleConfig::Kind;

// Any positive mass gives the same motion, since the motors are unlimited; this is the wheeled car's density.
constexpr double kDensity = 2143;  // [kg/m³]

// As for the wheeled car: half as much again as the fastest command, so that disturbances are not cut off.
constexpr double kReserve = 1.5;

OdeWorldParams PlaneWorld() {
  OdeWorldParams params;
  params.gravity = 0;
  // The motors' rows are soft by cfm · mass / dt² of themselves; next to nothing, but not 0 (see OdeWorldParams).
  params.cfm = 1e-10;
  return params;
}

bool IsSpeed(Kind kind, int command) { return command == 0 || (kind == Kind::kHolonomic && command == 1); }

}  // namespace

PlaneBase::PlaneBase(const VehicleConfig& vehicle, double time_step, double parameter_spread)
    : config_(vehicle), time_step_(time_step), spread_(parameter_spread), world_(PlaneWorld()) {
  const auto ranges = config_.command_ranges();
  for (int i = 0; i < kMaxActionSize; ++i) {
    const bool speed = IsSpeed(config_.kind, i);
    limits_[i] = kReserve * std::max(std::abs(ranges[i].min), std::abs(ranges[i].max));
    max_steps_[i] = speed && config_.max_acceleration > 0 ? config_.max_acceleration * time_step
                                                          : std::numeric_limits<double>::infinity();
  }
  if (config_.kind == Kind::kAckermann) limits_[1] = config_.max_steering;  // a linkage has an end stop
  const double height = 0.3 * std::sqrt(vehicle.length * vehicle.width);
  const dVector3 size{vehicle.length, vehicle.width, height};
  body_ = world_.AddBoxBody(kDensity * vehicle.length * vehicle.width * height, size);
  plane_ = dJointCreatePlane2D(world_.id(), nullptr);
  dJointAttach(plane_, body_, nullptr);
  dJointSetPlane2DXParam(plane_, dParamFMax, dInfinity);
  dJointSetPlane2DYParam(plane_, dParamFMax, dInfinity);
  dJointSetPlane2DAngleParam(plane_, dParamFMax, dInfinity);
}

void PlaneBase::SetLag(double lag) { episode_.blend = lag > 0 ? -std::expm1(-time_step_ / lag) : 1.0; }

void PlaneBase::Reset(const Pose& pose, RandomStream& random) {
  episode_ = Episode{};
  double lag = config_.lag;
  if (spread_ > 0) {
    // The lag stands for mass over traction: a heavier car or a more slippery floor answers later.
    const double mass_factor = random.Uniform(1 - spread_, 1 + spread_);
    const double friction_factor = random.Uniform(1 - spread_, 1 + spread_);
    lag *= mass_factor / friction_factor;
  }
  SetLag(lag);
  PlaceBody(body_, pose.x, pose.y, 0, pose.yaw);
}

void PlaneBase::Command(const VehicleCommand& command) {
  for (int i = 0; i < kMaxActionSize; ++i) episode_.target[i] = std::clamp(command[i], -limits_[i], limits_[i]);
}

PlaneBase::Velocity PlaneBase::BodyVelocity() const {
  const VehicleCommand& c = episode_.current;
  if (config_.kind == Kind::kHolonomic) return {c[0], c[1], c[2]};
  if (config_.kind == Kind::kPlaneCar) return {c[0], 0, c[1]};
  const double yaw_rate = c[0] * std::tan(c[1]) / config_.wheel_base;
  return {c[0], 0.5 * config_.wheel_base * yaw_rate, yaw_rate};
}

void PlaneBase::Step() {
  Episode& e = episode_;
  for (int i = 0; i < config_.action_size(); ++i) {
    e.current[i] += std::clamp(e.blend * (e.target[i] - e.current[i]), -max_steps_[i], max_steps_[i]);
  }
  const Velocity v = BodyVelocity();
  const dReal* rotation = dBodyGetRotation(body_);  // 3 × 4, row-major; first column is body x in W, second body y
  dJointSetPlane2DXParam(plane_, dParamVel, v.x * rotation[0] + v.y * rotation[1]);
  dJointSetPlane2DYParam(plane_, dParamVel, v.x * rotation[4] + v.y * rotation[5]);
  dJointSetPlane2DAngleParam(plane_, dParamVel, v.yaw_rate);
  world_.Step(time_step_);
}

Motion PlaneBase::motion() const {
  const dReal* position = dBodyGetPosition(body_);
  const Velocity v = BodyVelocity();
  return {position[0], position[1], 0, BodyYaw(body_), v.x, v.y, 0, v.yaw_rate};
}

std::string PlaneBase::Save() const {
  BlobWriter blob;
  blob.Put(episode_);
  WriteBody(body_, blob);
  return blob.Take();
}

void PlaneBase::Load(const std::string& bytes) {
  BlobReader blob(bytes);
  blob.Get(episode_);
  ReadBody(body_, blob);
  blob.Finish();
}

}  // namespace cairn::actors
