#include "tests/actors/vehicles/wheeled_car/hinged_car.h"

#include <algorithm>
#include <cmath>

namespace cairn::actors {

HingedCar::HingedCar(const WheeledCarParams& params, double time_step, double parameter_spread)
    : params_(params), time_step_(time_step), spread_(parameter_spread), world_(params.world) {
  const dVector3 size{params_.length, params_.width, params_.height};
  chassis_ = world_.AddBoxBody(params_.chassis_mass, size);
  dBodySetPosition(chassis_, 0, 0, params_.chassis_height);
  AddWheel(0, 0.5 * params_.track);
  AddWheel(1, -0.5 * params_.track);
}

void HingedCar::AddWheel(int wheel, double y) {
  wheels_[wheel] = world_.AddSphereBody(params_.wheel_mass, params_.wheel_radius);
  dBodySetPosition(wheels_[wheel], 0, y, params_.wheel_radius);
  const dJointID hinge = dJointCreateHinge(world_.id(), nullptr);
  dJointAttach(hinge, wheels_[wheel], chassis_);  // in this order the hinge's rate is the wheel's, forwards positive
  dJointSetHingeAnchor(hinge, 0, y, params_.wheel_radius);
  dJointSetHingeAxis(hinge, 0, 1, 0);
  dJointSetHingeParam(hinge, dParamFMax, params_.motor_torque);
  hinges_[wheel] = hinge;
}

void HingedCar::Reset(const Pose& pose, RandomStream& random) {
  episode_ = Episode{};
  if (spread_ > 0) {
    episode_.mass_factor = random.Uniform(1 - spread_, 1 + spread_);
    episode_.friction_factor = random.Uniform(1 - spread_, 1 + spread_);
  }
  ApplyParameters();
  SetMotors();
  PlaceBody(chassis_, pose.x, pose.y, params_.chassis_height, pose.yaw);
  for (int wheel = 0; wheel < 2; ++wheel) {
    const double side = (wheel == 0 ? 0.5 : -0.5) * params_.track;
    PlaceBody(wheels_[wheel], pose.x - side * std::sin(pose.yaw), pose.y + side * std::cos(pose.yaw),
              params_.wheel_radius, pose.yaw);
  }
}

void HingedCar::ApplyParameters() {
  if (spread_ == 0) return;
  dMass mass;
  dMassSetBoxTotal(&mass, params_.chassis_mass * episode_.mass_factor, params_.length, params_.width, params_.height);
  dBodySetMass(chassis_, &mass);
}

void HingedCar::Command(const VehicleCommand& command) {
  const double speed = command[0], yaw_rate = command[1];
  const double limit = params_.wheel_speed_limit;
  for (int wheel = 0; wheel < 2; ++wheel) {
    const double side = (wheel == 0 ? 0.5 : -0.5) * params_.track;
    episode_.motor_speed[wheel] = std::clamp((speed - side * yaw_rate) / params_.wheel_radius, -limit, limit);
  }
  SetMotors();
}

void HingedCar::SetMotors() {
  for (int wheel = 0; wheel < 2; ++wheel) dJointSetHingeParam(hinges_[wheel], dParamVel, episode_.motor_speed[wheel]);
}

// The friction pyramid turns with the car, so that grip does not depend on the heading in W.
void HingedCar::AddContacts() {
  const dReal* rotation = dBodyGetRotation(chassis_);
  const double norm = std::hypot(rotation[0], rotation[4]);
  const double along_x = rotation[0] / norm, along_y = rotation[4] / norm;
  FloorSurface surface = params_.wheel_surface;
  surface.friction *= episode_.friction_factor;
  for (const dBodyID wheel : wheels_) {
    world_.AddFloorContact(wheel, dBodyGetPosition(wheel), params_.wheel_radius, surface, along_x, along_y);
  }
  const double caster_z = params_.caster_radius + params_.caster_clearance - params_.chassis_height;
  for (const double caster_x : {params_.caster_x, -params_.caster_x}) {
    dVector3 center;
    dBodyGetRelPointPos(chassis_, caster_x, 0, caster_z, center);
    world_.AddFloorContact(chassis_, center, params_.caster_radius, params_.caster_surface, along_x, along_y);
  }
}

void HingedCar::Step() {
  AddContacts();
  world_.Step(time_step_);
}

Motion HingedCar::motion() const {
  const dReal* position = dBodyGetPosition(chassis_);
  const dReal* rotation = dBodyGetRotation(chassis_);  // 3 × 4, row-major; first column is body x in W
  const dReal* v = dBodyGetLinearVel(chassis_);
  const dReal* w = dBodyGetAngularVel(chassis_);
  Motion motion{position[0], position[1], 0, BodyYaw(chassis_), 0, 0, 0, 0};
  motion.vx = v[0] * rotation[0] + v[1] * rotation[4] + v[2] * rotation[8];
  motion.yaw_rate = w[0] * rotation[2] + w[1] * rotation[6] + w[2] * rotation[10];
  return motion;
}

std::string HingedCar::Save() const {
  BlobWriter blob;
  blob.Put(episode_);
  WriteBody(chassis_, blob);
  for (const dBodyID wheel : wheels_) WriteBody(wheel, blob);
  return blob.Take();
}

void HingedCar::Load(const std::string& bytes) {
  BlobReader blob(bytes);
  blob.Get(episode_);
  ReadBody(chassis_, blob);
  for (const dBodyID wheel : wheels_) ReadBody(wheel, blob);
  blob.Finish();
  ApplyParameters();
  SetMotors();
}

}  // namespace cairn::actors
