#include "actors/vehicles/quadrotor/quadrotor.h"

#include <algorithm>
#include <cmath>

namespace cairn::actors {
namespace {

// Signs of the rotors at (+, +), (−, +), (−, −), (+, −): where they stand along x and y, and which way they turn.
constexpr std::array<double, 4> kX{1, -1, -1, 1};
constexpr std::array<double, 4> kY{1, 1, -1, -1};
constexpr std::array<double, 4> kSpin{1, -1, 1, -1};

// thrust += s · change with the largest s ≤ 1 that keeps every rotor within [0, max].
void AddWithin(double max, const std::array<double, 4>& change, std::array<double, 4>* thrust) {
  double scale = 1;
  for (size_t i = 0; i < 4; ++i) {
    const double room = change[i] > 0 ? max - (*thrust)[i] : (*thrust)[i];
    scale = std::min(scale, room / std::max(std::abs(change[i]), 1e-12));
  }
  for (size_t i = 0; i < 4; ++i) (*thrust)[i] += scale * change[i];
}

}  // namespace

QuadrotorParams QuadrotorParams::ScaledTo(const VehicleConfig& vehicle) {
  QuadrotorParams p;
  const double s = vehicle.circumscribed_radius() / p.radius;
  p.radius = vehicle.circumscribed_radius();
  p.mass *= s * s * s;
  for (double& inertia : p.inertia) inertia *= s * s * s * s * s;
  p.arm *= s;
  p.max_thrust *= s * s * s;
  p.torque_per_thrust *= s;
  // As for the cars: half as much again as the fastest command, so that disturbances are not cut off.
  p.speed_limit = 1.5 * std::max(std::abs(vehicle.min_speed), vehicle.max_speed);
  return p;
}

Quadrotor::Quadrotor(const QuadrotorParams& params, double time_step, double parameter_spread)
    : params_(params),
      time_step_(time_step),
      spread_(parameter_spread),
      blend_(-std::expm1(-time_step / params.motor_lag)),
      world_(params.world),
      body_(dBodyCreate(world_.id())) {
  ApplyParameters();
}

void Quadrotor::ApplyParameters() {
  const double f = episode_.mass_factor;
  dMass mass;
  dMassSetParameters(&mass, f * params_.mass, 0, 0, 0, f * params_.inertia[0], f * params_.inertia[1],
                     f * params_.inertia[2], 0, 0, 0);
  dBodySetMass(body_, &mass);
}

void Quadrotor::Reset(const Pose& pose, RandomStream& random) {
  episode_ = Episode{};
  if (spread_ > 0) {
    episode_.mass_factor = random.Uniform(1 - spread_, 1 + spread_);
    episode_.thrust_factor = random.Uniform(1 - spread_, 1 + spread_);
    ApplyParameters();
  }
  episode_.yaw = pose.yaw;
  const double weight = params_.mass * episode_.mass_factor * params_.world.gravity;
  episode_.thrust.fill(0.25 * weight / episode_.thrust_factor);
  PlaceBody(body_, pose.x, pose.y, pose.z, pose.yaw);
}

void Quadrotor::Command(const VehicleCommand& command) {
  for (int i = 0; i < 3; ++i) {
    episode_.command[i] = std::clamp(command[i], -params_.speed_limit, params_.speed_limit);
  }
}

// The wanted acceleration, gravity made up for, is the wanted thrust vector; its direction in the body's frame gives
// the tilt error, the heading of the body's x axis the yaw error.
Quadrotor::Wrench Quadrotor::Control() const {
  const dReal* r = dBodyGetRotation(body_);  // 3 × 4, row-major; columns are the body's axes in W
  const dReal* v = dBodyGetLinearVel(body_);
  const dReal* w = dBodyGetAngularVel(body_);
  const double c = std::cos(episode_.yaw), s = std::sin(episode_.yaw);
  const VehicleCommand& command = episode_.command;
  double ax = params_.velocity_gain * (c * command[0] - s * command[1] - v[0]);
  double ay = params_.velocity_gain * (s * command[0] + c * command[1] - v[1]);
  const double climb = params_.velocity_gain * (command[2] - v[2]);
  const double az = params_.world.gravity + std::clamp(climb, -params_.max_climb, params_.max_climb);
  const double level = std::sqrt(ax * ax + ay * ay), limit = az * std::tan(params_.max_tilt);
  if (level > limit) {
    ax *= limit / level;
    ay *= limit / level;
  }
  const double norm = std::sqrt(ax * ax + ay * ay + az * az);
  Wrench wanted;
  // What the height needs at the tilt as it stands: on its way to the wanted tilt it neither sinks nor climbs.
  wanted.thrust = r[10] > 0 ? params_.mass * az / std::max(r[10], std::cos(params_.max_tilt)) : 0;
  const double tilt_x = (r[0] * ax + r[4] * ay + r[8] * az) / norm;  // wanted axis in the body's frame
  const double tilt_y = (r[1] * ax + r[5] * ay + r[9] * az) / norm;
  const double yaw_error = c * r[4] - s * r[0];          // sine of its yaw less the held one, times the level part of x
  const double error[3] = {tilt_y, -tilt_x, yaw_error};  // axis × wanted axis: wrong way round the torque below
  for (int k = 0; k < 3; ++k) {
    const double rate = r[k] * w[0] + r[4 + k] * w[1] + r[8 + k] * w[2];
    const double f = params_.attitude_frequency;
    const double e = std::clamp(error[k], -params_.max_attitude_error, params_.max_attitude_error);
    wanted.torque[k] = -params_.inertia[k] * (f * f * e + 2 * params_.attitude_damping * f * rate);
  }
  return wanted;
}

// Solves thrust = Σ f, torque x = Σ y f, torque y = −Σ x f, torque z = Σ spin · torque_per_thrust · f for the rotors.
// Where a rotor cannot give that, tilting goes first, then turning, and each shrinks as a whole until all rotors can:
// drag makes so little torque that a small turn would eat up the rest. The reserve keeps enough to stop any tilting, or
// a fast descent would tip it over.
std::array<double, 4> Quadrotor::Mix(const Wrench& wanted) const {
  const double reserve = params_.torque_reserve * params_.max_thrust;
  const double common = std::clamp(0.25 * wanted.thrust, reserve, params_.max_thrust - reserve);
  std::array<double, 4> thrust, tilting, turning;
  thrust.fill(common);
  for (size_t i = 0; i < 4; ++i) {
    tilting[i] = 0.25 * (kY[i] * wanted.torque[0] - kX[i] * wanted.torque[1]) / params_.arm;
    turning[i] = 0.25 * kSpin[i] * wanted.torque[2] / params_.torque_per_thrust;
  }
  AddWithin(params_.max_thrust, tilting, &thrust);
  AddWithin(params_.max_thrust, turning, &thrust);
  return thrust;
}

void Quadrotor::Step() {
  const std::array<double, 4> wanted = Mix(Control());
  double thrust = 0, torque[3] = {0, 0, 0};
  for (size_t i = 0; i < 4; ++i) {
    double& f = episode_.thrust[i];
    f += blend_ * (wanted[i] - f);
    const double real = episode_.thrust_factor * f;
    thrust += real;
    torque[0] += kY[i] * params_.arm * real;
    torque[1] -= kX[i] * params_.arm * real;
    torque[2] += kSpin[i] * params_.torque_per_thrust * real;
  }
  dBodyAddRelForce(body_, 0, 0, thrust);
  dBodyAddRelTorque(body_, torque[0], torque[1], torque[2]);
  world_.Step(time_step_);
}

Motion Quadrotor::motion() const {
  const dReal* p = dBodyGetPosition(body_);
  const dReal* v = dBodyGetLinearVel(body_);
  const double c = std::cos(episode_.yaw), s = std::sin(episode_.yaw);
  return {p[0], p[1], p[2], episode_.yaw, c * v[0] + s * v[1], c * v[1] - s * v[0], v[2], 0};
}

std::string Quadrotor::Save() const {
  BlobWriter blob;
  blob.Put(episode_);
  WriteBody(body_, blob);
  return blob.Take();
}

void Quadrotor::Load(const std::string& bytes) {
  BlobReader blob(bytes);
  blob.Get(episode_);
  ReadBody(body_, blob);
  blob.Finish();
  ApplyParameters();
}

}  // namespace cairn::actors
