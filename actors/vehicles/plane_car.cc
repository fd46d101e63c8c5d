#include "actors/vehicles/plane_car.h"

#include <algorithm>
#include <cmath>

namespace cairn::actors {
namespace {

// Any positive mass gives the same motion, since the motors are unlimited; this is the wheeled car's density.
constexpr double kDensity = 2143;  // [kg/m³]

OdeWorldParams PlaneWorld() {
  OdeWorldParams params;
  params.gravity = 0;
  // The motors' rows are soft by cfm · mass / dt² of themselves; next to nothing, but not 0 (see OdeWorldParams).
  params.cfm = 1e-10;
  return params;
}

}  // namespace

PlaneCar::PlaneCar(const VehicleConfig& vehicle, double time_step, double parameter_spread)
    : time_step_(time_step),
      spread_(parameter_spread),
      lag_(vehicle.lag),
      // As for the wheeled car: half as much again as the fastest command.
      speed_limit_(1.5 * std::max(std::abs(vehicle.min_speed), std::abs(vehicle.max_speed))),
      yaw_rate_limit_(1.5 * vehicle.max_yaw_rate),
      world_(PlaneWorld()) {
  const double height = 0.3 * std::sqrt(vehicle.length * vehicle.width);
  const dVector3 size{vehicle.length, vehicle.width, height};
  body_ = world_.AddBoxBody(kDensity * vehicle.length * vehicle.width * height, size);
  plane_ = dJointCreatePlane2D(world_.id(), nullptr);
  dJointAttach(plane_, body_, nullptr);
  dJointSetPlane2DXParam(plane_, dParamFMax, dInfinity);
  dJointSetPlane2DYParam(plane_, dParamFMax, dInfinity);
  dJointSetPlane2DAngleParam(plane_, dParamFMax, dInfinity);
}

void PlaneCar::SetLag(double lag) { episode_.blend = lag > 0 ? -std::expm1(-time_step_ / lag) : 1.0; }

void PlaneCar::Reset(double x, double y, double yaw, RandomStream& random) {
  episode_ = Episode{};
  double lag = lag_;
  if (spread_ > 0) {
    // The lag stands for mass over traction: a heavier car or a more slippery floor answers later.
    const double mass_factor = random.Uniform(1 - spread_, 1 + spread_);
    const double friction_factor = random.Uniform(1 - spread_, 1 + spread_);
    lag *= mass_factor / friction_factor;
  }
  SetLag(lag);
  PlaceBody(body_, x, y, 0, yaw);
}

void PlaneCar::Command(double speed, double yaw_rate) {
  episode_.target_speed = std::clamp(speed, -speed_limit_, speed_limit_);
  episode_.target_yaw_rate = std::clamp(yaw_rate, -yaw_rate_limit_, yaw_rate_limit_);
}

void PlaneCar::Step() {
  Episode& e = episode_;
  e.speed += e.blend * (e.target_speed - e.speed);
  e.yaw_rate += e.blend * (e.target_yaw_rate - e.yaw_rate);
  const dReal* rotation = dBodyGetRotation(body_);
  dJointSetPlane2DXParam(plane_, dParamVel, e.speed * rotation[0]);
  dJointSetPlane2DYParam(plane_, dParamVel, e.speed * rotation[4]);
  dJointSetPlane2DAngleParam(plane_, dParamVel, e.yaw_rate);
  world_.Step(time_step_);
}

GroundState PlaneCar::state() const {
  const dReal* position = dBodyGetPosition(body_);
  return {position[0], position[1], BodyYaw(body_), episode_.speed, episode_.yaw_rate};
}

std::string PlaneCar::Save() const {
  BlobWriter blob;
  blob.Put(episode_);
  WriteBody(body_, blob);
  return blob.Take();
}

void PlaneCar::Load(const std::string& bytes) {
  BlobReader blob(bytes);
  blob.Get(episode_);
  ReadBody(body_, blob);
  blob.Finish();
}

}  // namespace cairn::actors
