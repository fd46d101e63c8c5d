#include "actors/vehicles/quadruped/quadruped.h"

#include <algorithm>
#include <cmath>

namespace cairn::actors {
namespace {

// Signs of the hips: left and right in front, left and right behind.
constexpr std::array<double, 4> kX{1, 1, -1, -1};
constexpr std::array<double, 4> kY{1, -1, 1, -1};

void RotationAboutY(double angle, dQuaternion q) {
  q[0] = std::cos(0.5 * angle);
  q[1] = q[3] = 0;
  q[2] = std::sin(0.5 * angle);
}

// Puts a link of `length` at rest with its upper end at `top`; its lower end replaces `top`.
void PlaceLink(dBodyID link, const dQuaternion q, double length, dVector3 top) {
  PlaceBody(link, 0, 0, 0, 0);
  dBodySetQuaternion(link, q);
  dVector3 down;
  dBodyVectorToWorld(link, 0, 0, -length, down);
  dBodySetPosition(link, top[0] + 0.5 * down[0], top[1] + 0.5 * down[1], top[2] + 0.5 * down[2]);
  for (int k = 0; k < 3; ++k) top[k] += down[k];
}

// A foot of radius r under a shank that turns by dθ rolls on by r dθ: over the way dx of its centre below the hip.
double Rolling(const QuadrupedParams& p) {
  const double height = p.stance_height - p.foot_radius, dx = 0.1 * height;
  const LegAngles front = InverseKinematics(p.leg, {dx, 0, -height}),
                  back = InverseKinematics(p.leg, {-dx, 0, -height});
  return p.foot_radius * (back.hip + back.knee - front.hip - front.knee) / (2 * dx);
}

// Dot product of columns i and j of two rotations (3 × 4, row-major).
double Dot(const dReal* a, int i, const dReal* b, int j) {
  return a[i] * b[j] + a[4 + i] * b[4 + j] + a[8 + i] * b[8 + j];
}

}  // namespace

QuadrupedParams QuadrupedParams::ScaledTo(const VehicleConfig& vehicle) {
  QuadrupedParams p;
  const double length_scale = vehicle.length / p.length, width_scale = vehicle.width / p.width;
  const double s = std::sqrt(length_scale * width_scale), t = std::sqrt(s), mass_scale = s * s * s;
  p.length = vehicle.length;
  p.width = vehicle.width;
  p.hip_x *= length_scale;
  p.hip_y *= width_scale;
  for (double* length : {&p.height, &p.leg.thigh, &p.leg.shank, &p.link_width, &p.foot_radius, &p.stance_height,
                         &p.trot.lift, &p.trot.max_step, &p.world.contact_surface_layer}) {
    *length *= s;
  }
  for (double* mass : {&p.trunk_mass, &p.thigh_mass, &p.shank_mass}) *mass *= mass_scale;
  for (double* rate : {&p.joint_gain, &p.joint_speed}) *rate /= t;
  p.joint_torque *= mass_scale * s;
  for (double* time : {&p.trot.period, &p.trot.raibert_gain}) *time *= t;
  for (double* speed : {&p.trot.rest_speed, &p.world.max_correcting_velocity}) *speed *= t;
  p.world.cfm /= mass_scale;
  p.surface.soft_cfm /= mass_scale;
  // As for the cars: half as much again as the fastest command, so that disturbances are not cut off.
  p.speed_limit = 1.5 * std::max(std::abs(vehicle.min_speed), std::abs(vehicle.max_speed));
  p.yaw_rate_limit = 1.5 * vehicle.max_yaw_rate;
  p.yaw_acceleration /= s;
  p.trot.leg_height = p.stance_height - p.foot_radius;
  p.trot.rolling = Rolling(p);
  for (int leg = 0; leg < Quadruped::kLegs; ++leg) {
    p.trot.hip_x[leg] = kX[leg] * p.hip_x;
    p.trot.hip_y[leg] = kY[leg] * p.hip_y;
  }
  return p;
}

Quadruped::Quadruped(const QuadrupedParams& params, double time_step, double parameter_spread)
    : params_(params), time_step_(time_step), spread_(parameter_spread), world_(params.world), trot_(params.trot) {
  const dVector3 size{params_.length, params_.width, params_.height};
  trunk_ = world_.AddBoxBody(params_.trunk_mass, size);
  for (int leg = 0; leg < kLegs; ++leg) AddLeg(leg);
}

// Straight down from a trunk at the origin: there all angles are 0.
void Quadruped::AddLeg(int leg) {
  const double x = params_.trot.hip_x[leg], y = params_.trot.hip_y[leg];
  const double thigh = params_.leg.thigh, shank = params_.leg.shank, w = params_.link_width;
  Leg& l = legs_[leg];
  const dVector3 thigh_size{w, w, thigh}, shank_size{w, w, shank};
  l.thigh = world_.AddBoxBody(params_.thigh_mass, thigh_size);
  dBodySetPosition(l.thigh, x, y, -0.5 * thigh);
  l.shank = world_.AddBoxBody(params_.shank_mass, shank_size);
  dBodySetPosition(l.shank, x, y, -thigh - 0.5 * shank);
  l.hip = dJointCreateUniversal(world_.id(), nullptr);
  dJointAttach(l.hip, trunk_, l.thigh);
  dJointSetUniversalAnchor(l.hip, x, y, 0);
  dJointSetUniversalAxis1(l.hip, 1, 0, 0);  // fixed to the trunk
  dJointSetUniversalAxis2(l.hip, 0, 1, 0);  // fixed to the thigh
  dJointSetUniversalParam(l.hip, dParamFMax1, params_.joint_torque);
  dJointSetUniversalParam(l.hip, dParamFMax2, params_.joint_torque);
  l.knee = dJointCreateHinge(world_.id(), nullptr);
  dJointAttach(l.knee, l.shank, l.thigh);
  dJointSetHingeAnchor(l.knee, x, y, -thigh);
  dJointSetHingeAxis(l.knee, 0, 1, 0);
  dJointSetHingeParam(l.knee, dParamFMax, params_.joint_torque);
}

void Quadruped::Reset(const Pose& pose, RandomStream& random) {
  episode_ = Episode{};
  if (spread_ > 0) {
    episode_.mass_factor = random.Uniform(1 - spread_, 1 + spread_);
    episode_.friction_factor = random.Uniform(1 - spread_, 1 + spread_);
  }
  ApplyParameters();
  trot_.Reset();
  PlaceBody(trunk_, pose.x, pose.y, params_.stance_height, pose.yaw);
  const LegAngles angles = InverseKinematics(params_.leg, {0, 0, -params_.trot.leg_height});
  for (int leg = 0; leg < kLegs; ++leg) PlaceLeg(leg, pose, angles);
  episode_.wanted.fill(angles);
}

void Quadruped::PlaceLeg(int leg, const Pose& pose, const LegAngles& angles) {
  dVector3 end;
  dBodyGetRelPointPos(trunk_, params_.trot.hip_x[leg], params_.trot.hip_y[leg], 0, end);
  const dQuaternion heading{std::cos(0.5 * pose.yaw), 0, 0, std::sin(0.5 * pose.yaw)};
  dQuaternion pitch, q;
  RotationAboutY(angles.hip, pitch);
  dQMultiply0(q, heading, pitch);
  PlaceLink(legs_[leg].thigh, q, params_.leg.thigh, end);
  RotationAboutY(angles.hip + angles.knee, pitch);
  dQMultiply0(q, heading, pitch);
  PlaceLink(legs_[leg].shank, q, params_.leg.shank, end);
}

void Quadruped::ApplyParameters() {
  if (spread_ == 0) return;
  dMass mass;
  dMassSetBoxTotal(&mass, params_.trunk_mass * episode_.mass_factor, params_.length, params_.width, params_.height);
  dBodySetMass(trunk_, &mass);
}

void Quadruped::Command(const VehicleCommand& command) {
  episode_.command[0] = std::clamp(command[0], -params_.speed_limit, params_.speed_limit);
  episode_.command[1] = std::clamp(command[1], -params_.yaw_rate_limit, params_.yaw_rate_limit);
}

// R_trunkᵀ R_thigh = Rx(abduction) Ry(hip), R_thighᵀ R_shank = Ry(knee).
LegAngles Quadruped::angles(int leg) const {
  const dReal* trunk = dBodyGetRotation(trunk_);
  const dReal* thigh = dBodyGetRotation(legs_[leg].thigh);
  const dReal* shank = dBodyGetRotation(legs_[leg].shank);
  return {std::atan2(Dot(trunk, 2, thigh, 1), Dot(trunk, 1, thigh, 1)),
          std::atan2(Dot(trunk, 0, thigh, 2), Dot(trunk, 0, thigh, 0)),
          std::atan2(Dot(thigh, 0, shank, 2), Dot(thigh, 0, shank, 0))};
}

// A step of the command as it stands would throw the trunk over.
void Quadruped::Approach() {
  const double dv = params_.acceleration * time_step_, dw = params_.yaw_acceleration * time_step_;
  Trot::Velocity& target = episode_.target;
  target.x += std::clamp(episode_.command[0] - target.x, -dv, dv);
  target.yaw_rate += std::clamp(episode_.command[1] - target.yaw_rate, -dw, dw);
}

Trot::Velocity Quadruped::Measure() const {
  const Motion m = motion();
  return {m.vx, m.vy, m.yaw_rate};
}

// Each motor turns as fast as its joint shall in this step, and makes up for where the joint is now.
void Quadruped::DriveJoints() {
  const auto feet = trot_.Advance(time_step_, episode_.target, Measure());
  const double gain = params_.joint_gain, rate = 1 / time_step_, limit = params_.joint_speed;
  const auto speed = [gain, rate, limit](double next, double wanted, double now) {
    return std::clamp(rate * (next - wanted) + gain * (wanted - now), -limit, limit);
  };
  for (int leg = 0; leg < kLegs; ++leg) {
    const LegAngles next = InverseKinematics(params_.leg, feet[leg]), now = angles(leg);
    LegAngles& wanted = episode_.wanted[leg];
    const Leg& l = legs_[leg];
    // The universal joint's motors turn the trunk against the thigh.
    dJointSetUniversalParam(l.hip, dParamVel1, -speed(next.abduction, wanted.abduction, now.abduction));
    dJointSetUniversalParam(l.hip, dParamVel2, -speed(next.hip, wanted.hip, now.hip));
    dJointSetHingeParam(l.knee, dParamVel, speed(next.knee, wanted.knee, now.knee));
    wanted = next;
  }
}

// The friction pyramid turns with the trunk, so that grip does not depend on the heading in W.
void Quadruped::AddContacts() {
  const dReal* rotation = dBodyGetRotation(trunk_);
  const double norm = std::hypot(rotation[0], rotation[4]);
  if (!(norm > 0)) return;
  FloorSurface surface = params_.surface;
  surface.friction *= episode_.friction_factor;
  for (int leg = 0; leg < kLegs; ++leg) {
    dVector3 center;
    dBodyGetRelPointPos(legs_[leg].shank, 0, 0, -0.5 * params_.leg.shank, center);
    const dJointID contact = world_.AddFloorContact(legs_[leg].shank, center, params_.foot_radius, surface,
                                                    rotation[0] / norm, rotation[4] / norm);
    if (feedback_ == nullptr) continue;
    (*feedback_)[leg] = {};
    if (contact != nullptr) dJointSetFeedback(contact, &(*feedback_)[leg]);
  }
}

void Quadruped::Step() {
  Approach();
  DriveJoints();
  AddContacts();
  world_.Step(time_step_);
}

Motion Quadruped::motion() const {
  const dReal* p = dBodyGetPosition(trunk_);
  const dReal* v = dBodyGetLinearVel(trunk_);
  const double yaw = BodyYaw(trunk_), c = std::cos(yaw), s = std::sin(yaw);
  return {p[0], p[1], 0, yaw, c * v[0] + s * v[1], c * v[1] - s * v[0], 0, dBodyGetAngularVel(trunk_)[2]};
}

// Tilted too far, or a corner of the trunk on the floor.
bool Quadruped::fallen() const {
  const dReal* r = dBodyGetRotation(trunk_);
  const double down =
      0.5 * (std::abs(r[8]) * params_.length + std::abs(r[9]) * params_.width + std::abs(r[10]) * params_.height);
  return r[10] < std::cos(params_.max_tilt) || height() < down;
}

std::string Quadruped::Save() const {
  BlobWriter blob;
  blob.Put(episode_);
  blob.Put(trot_.state());
  WriteBody(trunk_, blob);
  for (const Leg& leg : legs_) {
    WriteBody(leg.thigh, blob);
    WriteBody(leg.shank, blob);
  }
  return blob.Take();
}

void Quadruped::Load(const std::string& bytes) {
  BlobReader blob(bytes);
  Trot::State state;
  blob.Get(episode_);
  blob.Get(state);
  trot_.set_state(state);
  ReadBody(trunk_, blob);
  for (const Leg& leg : legs_) {
    ReadBody(leg.thigh, blob);
    ReadBody(leg.shank, blob);
  }
  blob.Finish();
  ApplyParameters();
}

}  // namespace cairn::actors
