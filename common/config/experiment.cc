#include "common/config/experiment.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cmath>

namespace cairn {

bool TransportConfig::leaves_host() const {
  if (broker.empty()) return ttl > 0;
  const std::string host = broker.substr(0, broker.find(':'));
  in_addr address{};
  const bool numeric = inet_pton(AF_INET, host.c_str(), &address) == 1;
  return !(host == "localhost" || (numeric && ntohl(address.s_addr) >> 24 == 127));
}

double VehicleConfig::inscribed_radius() const { return radius > 0 ? radius : 0.5 * std::min(length, width); }

double VehicleConfig::circumscribed_radius() const { return radius > 0 ? radius : 0.5 * std::hypot(length, width); }

double VehicleConfig::top_yaw_rate() const {
  if (kind != Kind::kAckermann) return max_yaw_rate;
  return std::max(std::abs(min_speed), std::abs(max_speed)) * std::tan(max_steering) / wheel_base;
}

std::array<CommandRange, kMaxActionSize> VehicleConfig::command_ranges() const {
  const CommandRange speed{min_speed, max_speed}, yaw_rate{-max_yaw_rate, max_yaw_rate};
  switch (kind) {
    case Kind::kWheeledCar:
    case Kind::kPlaneCar:
    case Kind::kQuadruped:
      break;
    case Kind::kHolonomic:
      return {speed, {-max_speed, max_speed}, yaw_rate};
    case Kind::kAckermann:
      return {speed, {-max_steering, max_steering}, {}};
    case Kind::kQuadrotor:
      return {speed, {-max_speed, max_speed}, {-max_speed, max_speed}};
  }
  return {speed, yaw_rate, {}};
}

int ObservationSize(const Experiment& experiment) {
  const ObservationConfig& observation = experiment.observation;
  const VehicleConfig& vehicle = experiment.vehicle;
  int size = 0;
  if (observation.position) size += vehicle.dimension();
  if (observation.heading && vehicle.turns()) size += 2;
  if (observation.velocity) size += vehicle.holonomic() ? 3 : 2;
  if (observation.d_min) size += 1;
  if (observation.look_ahead) size += 2 * vehicle.dimension();
  if (observation.rays) size += vehicle.scan.beams;
  return size + observation.last_actions * vehicle.action_size();
}

int EpisodeSteps(const Experiment& experiment, double max_cost) {
  const EnvironmentConfig& environment = experiment.environment;
  if (environment.max_episode_steps > 0) return environment.max_episode_steps;
  const double steps = std::ceil(6.0 * max_cost / (experiment.vehicle.max_speed * environment.control_period));
  return static_cast<int>(std::clamp(steps, 1.0, 1e6));
}

int EvaluationSteps(const Experiment& experiment, double max_cost) {
  const int configured = experiment.evaluation.max_steps;
  return configured > 0 ? configured : 2 * EpisodeSteps(experiment, max_cost);
}

}  // namespace cairn
