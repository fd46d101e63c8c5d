#include "actors/safety/braking.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "actors/command.h"
#include "actors/vehicles/vehicle.h"

namespace cairn::actors {
namespace {

constexpr int kSpeeds = 6;         // measured, besides standing still
constexpr double kRunUp = 1.5;     // [s]; longer while the speed is not reached
constexpr double kLongest = 10;    // [s] of a run-up, and of a stop
constexpr double kRecovery = 0.1;  // [s]

// Way along a command's axis until the vehicle goes no farther.
double MeasureWay(Vehicle& vehicle, const Experiment& experiment, int axis, double speed) {
  const double rate = experiment.environment.physics_rate_hz;
  RandomStream unused(0, RandomPurpose::kParameters);
  vehicle.Reset({}, unused);
  VehicleCommand command = RestCommand(experiment.vehicle);
  command[static_cast<size_t>(axis)] = speed;
  vehicle.Command(command);
  const auto progress = [&] {
    const Motion m = vehicle.motion();
    return axis == 0 ? m.x : axis == 1 ? m.y : m.z;
  };
  const auto velocity = [&] {
    const Motion m = vehicle.motion();
    return std::abs(axis == 0 ? m.vx : axis == 1 ? m.vy : m.vz);
  };
  for (int i = 0; i < kLongest * rate && (i < kRunUp * rate || velocity() < 0.97 * std::abs(speed)); ++i)
    vehicle.Step();
  vehicle.Command(RestCommand(experiment.vehicle));
  const double begin = progress();
  double way = 0;
  int still = 0;  // steps without getting farther
  for (int i = 0; i < kLongest * rate && still < 0.5 * rate; ++i) {
    vehicle.Step();
    const double gone = std::abs(progress() - begin);
    still = gone > way ? 0 : still + 1;
    way = std::max(way, gone);
  }
  return way;
}

double MeasureWay(Vehicle& vehicle, const Experiment& experiment, double speed) {
  double way = MeasureWay(vehicle, experiment, 0, speed);
  if (experiment.vehicle.dimension() == 3) {  // up and down are different engines
    way = std::max(way, MeasureWay(vehicle, experiment, 2, speed));
    way = std::max(way, MeasureWay(vehicle, experiment, 2, -speed));
  }
  return way;
}

}  // namespace

BrakingTable::BrakingTable(const Experiment& experiment) : step_(experiment.vehicle.max_speed / kSpeeds) {
  EnvironmentConfig exact = experiment.environment;
  exact.parameter_spread = 0;
  const std::unique_ptr<Vehicle> vehicle = MakeVehicle(experiment.vehicle, exact);
  ways_.push_back(0);
  for (int k = 1; k <= kSpeeds; ++k)
    ways_.push_back(std::max(ways_.back(), MeasureWay(*vehicle, experiment, k * step_)));
  const SafetyConfig& safety = experiment.safety;
  if (safety.stopping_distance > 0) {
    const double scale = safety.stopping_distance / ways_.back();
    for (double& way : ways_) way *= scale;
  }
  for (int k = 0; k <= kSpeeds; ++k) {
    reach_.push_back(safety.caution * ways_[static_cast<size_t>(k)] + safety.period * k * step_);
  }
}

double BrakingTable::StoppingDistance(double speed) const {
  const double at = speed / step_;
  const auto k = static_cast<size_t>(std::clamp(at, 0.0, static_cast<double>(ways_.size() - 2)));
  return ways_[k] + (at - static_cast<double>(k)) * (ways_[k + 1] - ways_[k]);
}

double BrakingTable::AllowedSpeed(double gap) const {
  if (gap <= 0) return gap / kRecovery;
  if (gap >= reach_.back()) return std::numeric_limits<double>::infinity();
  const auto next = std::upper_bound(reach_.begin(), reach_.end(), gap) - reach_.begin();
  const auto k = static_cast<size_t>(next - 1);
  return step_ * (static_cast<double>(k) + (gap - reach_[k]) / (reach_[k + 1] - reach_[k]));
}

}  // namespace cairn::actors
