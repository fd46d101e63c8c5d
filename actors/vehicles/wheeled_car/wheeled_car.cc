#include "actors/vehicles/wheeled_car/wheeled_car.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cairn::actors {
namespace {

constexpr std::array<double, 2> kSides{1, -1};  // left, right

// Turning rate about one of the body's axes; `rotation` is 3 × 4, row-major.
double Rate(const dReal* rotation, const dReal* w, int axis) {
  return w[0] * rotation[axis] + w[1] * rotation[4 + axis] + w[2] * rotation[8 + axis];
}

}  // namespace

WheeledCarParams WheeledCarParams::ScaledTo(const VehicleConfig& vehicle) {
  WheeledCarParams p;
  const double length_scale = vehicle.length / p.length;
  const double width_scale = vehicle.width / p.width;
  const double s = std::sqrt(length_scale * width_scale);
  const double mass_scale = s * s * s;
  p.length = vehicle.length;
  p.width = vehicle.width;
  p.track *= width_scale;
  p.caster_x *= length_scale;
  for (double* length : {&p.height, &p.chassis_height, &p.wheel_radius, &p.caster_radius, &p.caster_clearance,
                         &p.world.contact_surface_layer, &p.world.max_correcting_velocity}) {
    *length *= s;
  }
  p.chassis_mass *= mass_scale;
  p.wheel_mass *= mass_scale;
  p.motor_torque *= mass_scale * s;
  p.world.cfm /= mass_scale;
  p.wheel_surface.soft_cfm /= mass_scale;
  p.wheel_surface.friction = p.friction;
  p.caster_surface = p.wheel_surface;
  p.caster_surface.friction = 0;
  // No motor is endless: half as much again as the fastest command needs, so that disturbances are not cut off.
  const double top_speed = std::max(std::abs(vehicle.min_speed), std::abs(vehicle.max_speed));
  p.wheel_speed_limit = 1.5 * (top_speed + 0.5 * p.track * vehicle.max_yaw_rate) / p.wheel_radius;
  return p;
}

WheeledCar::WheeledCar(const WheeledCarParams& params, double time_step, double parameter_spread)
    : params_(params),
      time_step_(time_step),
      spread_(parameter_spread),
      wheel_inertia_(0.4 * params.wheel_mass * params.wheel_radius * params.wheel_radius),
      world_(params.world),
      body_(world_.AddSphereBody(1, 1)) {
  ApplyParameters();
}

// The chassis and both wheels as one rigid body whose origin is their centre of mass; what the wheels turn about their
// axles comes on top.
void WheeledCar::ApplyParameters() {
  const WheeledCarParams& p = params_;
  dMass total;
  dMassSetBoxTotal(&total, p.chassis_mass * episode_.mass_factor, p.length, p.width, p.height);
  dMassTranslate(&total, 0, 0, p.chassis_height);
  for (const double side : kSides) {
    dMass wheel;
    dMassSetSphereTotal(&wheel, p.wheel_mass, p.wheel_radius);
    dMassTranslate(&wheel, 0, side * p.track / 2, p.wheel_radius);
    dMassAdd(&total, &wheel);
  }
  origin_ = total.c[2];
  mass_ = total.mass;
  dMassTranslate(&total, 0, 0, -origin_);
  std::fill_n(total.c, 3, 0);  // without rounding errors
  dBodySetMass(body_, &total);
}

void WheeledCar::Reset(const Pose& pose, RandomStream& random) {
  episode_ = Episode{};
  if (spread_ > 0) {
    episode_.mass_factor = random.Uniform(1 - spread_, 1 + spread_);
    episode_.friction_factor = random.Uniform(1 - spread_, 1 + spread_);
    ApplyParameters();
  }
  // A hair deep: exactly on the floor the first rounding error would lift the wheels.
  PlaceBody(body_, pose.x, pose.y, origin_ - 0.01 * params_.world.contact_surface_layer, pose.yaw);
}

void WheeledCar::Command(const VehicleCommand& command) {
  const double speed = command[0], yaw_rate = command[1];
  const double limit = params_.wheel_speed_limit;
  for (int i = 0; i < 2; ++i) {
    const double side = 0.5 * kSides[i] * params_.track;
    episode_.wheels[i].target = std::clamp((speed - side * yaw_rate) / params_.wheel_radius, -limit, limit);
  }
}

// What the floor meets of a wheel in this step. Where the motor can, it turns the wheel at its target from now on,
// whatever the traction: the wheel is part of the body but for its surface's speed. Else the motor pushes with all it
// has, the wheel turns freely, and traction acts on the body through the axle alone.
FloorSurface WheeledCar::Drive(Wheel& wheel, bool touches, double ground_speed, double pitch_rate) const {
  const WheeledCarParams& p = params_;
  const double radius = p.wheel_radius, gain = time_step_ / wheel_inertia_;  // [rad/s / N m]
  FloorSurface surface = p.wheel_surface;
  surface.friction *= episode_.friction_factor;
  surface.speed = radius * wheel.target;
  const double grip = touches ? surface.friction * 0.5 * mass_ * p.world.gravity : 0;
  const double traction = std::clamp(0.5 * mass_ * (surface.speed - ground_speed) / time_step_, -grip, grip);
  wheel.push = (wheel.target - wheel.speed) / gain;
  const double wanted = wheel.push + radius * traction;
  wheel.free = std::abs(wanted) > p.motor_torque ? 1 : 0;
  if (wheel.free == 0) return surface;
  wheel.push = std::copysign(p.motor_torque, wanted);
  surface.speed = radius * (wheel.speed + pitch_rate + gain * wheel.push);
  surface.slip = radius * radius * gain;
  surface.height = radius;
  return surface;
}

// A wheel's speed after a step in which the floor drove the car with `traction` [N] and its pitch rate rose by
// `pitched`.
void WheeledCar::Turn(Wheel& wheel, double traction, double pitched) const {
  const double gain = time_step_ / wheel_inertia_, load = params_.wheel_radius * traction;
  const double wanted = (wheel.target - wheel.speed + pitched) / gain + load;
  const double torque = std::clamp(wanted, -params_.motor_torque, params_.motor_torque);
  const double change = gain * (torque - load) - pitched;
  wheel.owed = wheel.push - (wheel.free != 0 ? torque : change / gain);
  wheel.speed += change;
}

// The friction pyramid turns with the car, so that grip does not depend on the heading in W. Beside what the floor
// does, the chassis feels the motors' torques, the gyroscopic torque of the spinning wheels, and, where traction acts
// at the height of the axle, what the sideways force does further down (of the last step: it changes slowly).
void WheeledCar::Step() {
  const WheeledCarParams& p = params_;
  const dReal* rotation = dBodyGetRotation(body_);  // 3 × 4, row-major
  const dReal* w = dBodyGetAngularVel(body_);
  const double norm = std::hypot(rotation[0], rotation[4]);
  const double along_x = rotation[0] / norm, along_y = rotation[4] / norm;
  const double roll_rate = Rate(rotation, w, 0), pitch_rate = Rate(rotation, w, 1), yaw_rate = Rate(rotation, w, 2);
  std::array<dJointFeedback, 2> floor{};
  dVector3 center, v;
  double roll = 0, pitch = 0, spin = 0;
  for (int i = 0; i < 2; ++i) {
    Wheel& wheel = episode_.wheels[i];
    const double y = 0.5 * kSides[i] * p.track;
    dBodyGetRelPointPos(body_, 0, y, p.wheel_radius - origin_, center);
    dBodyGetRelPointVel(body_, 0, y, -origin_, v);
    const bool touches = center[2] <= p.wheel_radius;
    const FloorSurface surface = Drive(wheel, touches, v[0] * along_x + v[1] * along_y, pitch_rate);
    const dJointID contact = world_.AddFloorContact(body_, center, p.wheel_radius, surface, along_x, along_y);
    if (contact != nullptr) dJointSetFeedback(contact, &floor[i]);
    pitch += wheel.owed - wheel.push;
    roll += surface.height * wheel.side_force;
    spin += wheel_inertia_ * wheel.speed;
  }
  for (const double caster_x : {p.caster_x, -p.caster_x}) {
    dBodyGetRelPointPos(body_, caster_x, 0, p.caster_radius + p.caster_clearance - origin_, center);
    world_.AddFloorContact(body_, center, p.caster_radius, p.caster_surface, along_x, along_y);
  }
  dBodyAddRelTorque(body_, roll + spin * yaw_rate, pitch, -spin * roll_rate);
  world_.Step(time_step_);
  const double pitched = Rate(dBodyGetRotation(body_), dBodyGetAngularVel(body_), 1) - pitch_rate;
  for (int i = 0; i < 2; ++i) {
    const dReal* force = floor[i].f1;
    episode_.wheels[i].side_force = force[1] * along_x - force[0] * along_y;
    Turn(episode_.wheels[i], force[0] * along_x + force[1] * along_y, pitched);
  }
}

Motion WheeledCar::motion() const {
  const dReal* rotation = dBodyGetRotation(body_);  // first column is body x in W
  const dReal* w = dBodyGetAngularVel(body_);
  dVector3 position, v;  // of the chassis's centre
  dBodyGetRelPointPos(body_, 0, 0, params_.chassis_height - origin_, position);
  dBodyGetRelPointVel(body_, 0, 0, params_.chassis_height - origin_, v);
  Motion motion{position[0], position[1], 0, BodyYaw(body_), 0, 0, 0, 0};
  motion.vx = v[0] * rotation[0] + v[1] * rotation[4] + v[2] * rotation[8];
  motion.yaw_rate = Rate(rotation, w, 2);
  return motion;
}

double WheeledCar::chassis_height() const {
  dVector3 position;
  dBodyGetRelPointPos(body_, 0, 0, params_.chassis_height - origin_, position);
  return position[2];
}

std::string WheeledCar::Save() const {
  BlobWriter blob;
  blob.Put(episode_);
  WriteBody(body_, blob);
  return blob.Take();
}

void WheeledCar::Load(const std::string& bytes) {
  BlobReader blob(bytes);
  blob.Get(episode_);
  ReadBody(body_, blob);
  blob.Finish();
  ApplyParameters();
}

}  // namespace cairn::actors
