#include "actors/safety/braking.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "actors/command.h"
#include "common/core/check.h"

namespace cairn::actors {
namespace {

constexpr double kRunUp = 1.5;    // [s]
constexpr double kLongest = 10;   // [s] of a measured stop
constexpr double kAhead = 1;      // [s] of a predicted one
constexpr double kStill = 0.05;   // [s] in which a vehicle that stands …
constexpr double kCreep = 0.005;  // … moves by less than this many radii

int YawRateCommand(const VehicleConfig& vehicle) {
  if (vehicle.kind == VehicleConfig::Kind::kHolonomic) return 2;
  return vehicle.turns() && vehicle.kind != VehicleConfig::Kind::kAckermann ? 1 : -1;
}

}  // namespace

double StoppingDistance(const Experiment& experiment, const VehicleCommand& command) {
  EnvironmentConfig exact = experiment.environment;
  exact.parameter_spread = 0;
  const std::unique_ptr<Vehicle> vehicle = MakeVehicle(experiment.vehicle, exact);
  const double rate = exact.physics_rate_hz;
  RandomStream unused(0, RandomPurpose::kParameters);
  vehicle->Reset({}, unused);
  vehicle->Command(command);
  for (int i = 0; i < kRunUp * rate; ++i) vehicle->Step();
  const Motion begin = vehicle->motion();
  vehicle->Command(RestCommand(experiment.vehicle));
  double way = 0;
  int still = 0;  // steps without getting farther
  for (int i = 0; i < kLongest * rate && still < 0.5 * rate; ++i) {
    vehicle->Step();
    const Motion m = vehicle->motion();
    const double gone = std::hypot(m.x - begin.x, m.y - begin.y, m.z - begin.z);
    still = gone > way ? 0 : still + 1;
    way = std::max(way, gone);
  }
  return way;
}

BrakingTwin::BrakingTwin(const Experiment& experiment)
    : vehicle_(MakeVehicle(experiment.vehicle, experiment.environment)),
      rest_(RestCommand(experiment.vehicle)),
      turn_(YawRateCommand(experiment.vehicle)),
      rate_(experiment.environment.physics_rate_hz),
      period_(std::max(1, static_cast<int>(std::lround(experiment.safety.period * rate_)))),
      stretch_(experiment.safety.caution),
      radius_(experiment.vehicle.circumscribed_radius()),
      turn_arm_(experiment.vehicle.radius > 0 ? 0 : radius_) {
  const double declared = experiment.safety.stopping_distance;
  if (declared == 0) return;
  const double measured = StoppingDistance(experiment, {experiment.vehicle.max_speed, 0, 0});
  CAIRN_CHECK(measured > 0, "a vehicle that stands still at once has no way to stretch");
  stretch_ *= declared / measured;
}

void BrakingTwin::Follow(const Vehicle& vehicle, double drift) {
  state_ = vehicle.Save();
  drift_ = drift;
}

VehicleCommand BrakingTwin::WithDrift(VehicleCommand command, double drift) const {
  if (turn_ >= 0) command[static_cast<size_t>(turn_)] += drift;
  return command;
}

void BrakingTwin::Begin(const VehicleCommand& command) {
  vehicle_->Load(state_);
  vehicle_->Command(WithDrift(command, drift_));
}

double BrakingTwin::YawRateAfter(const VehicleCommand& command) {
  Begin(command);
  for (int i = 0; i < period_; ++i) vehicle_->Step();
  return vehicle_->motion().yaw_rate;
}

// What the vehicle moves in a physics step, in its own frame, is stretched and put at the end of the stretched way.
void BrakingTwin::Step() {
  vehicle_->Step();
  const Motion m = vehicle_->motion();
  const double c = std::cos(last_.yaw), s = std::sin(last_.yaw);
  const double dx = m.x - last_.x, dy = m.y - last_.y;
  const Vector3d moved = stretch_ * Vector3d(c * dx + s * dy, c * dy - s * dx, m.z - last_.z);
  const double turn = stretch_ * std::remainder(m.yaw - last_.yaw, 2 * std::numbers::pi);
  const Place& before = path_.back();
  turned_ += turn;
  path_.push_back({before.p + before.FromLocal(moved), std::cos(turned_), std::sin(turned_),
                   before.swept + moved.norm() + turn_arm_ * std::abs(turn)});
  last_ = m;
}

const std::vector<Place>& BrakingTwin::Drive(const VehicleCommand& command) {
  Begin(command);
  last_ = vehicle_->motion();
  turned_ = 0;
  path_.assign(1, Place{});
  for (int i = 0; i < period_; ++i) Step();
  vehicle_->Command(rest_);
  const auto window = static_cast<size_t>(kStill * rate_) + 1;
  for (int i = 0; i < kAhead * rate_; ++i) {
    Step();
    if (path_.size() > window && path_.back().swept - path_[path_.size() - 1 - window].swept < kCreep * radius_) break;
  }
  return path_;
}

}  // namespace cairn::actors
