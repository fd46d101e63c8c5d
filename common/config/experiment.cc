#include "common/config/experiment.h"

#include <algorithm>
#include <cmath>

namespace cairn {

double VehicleConfig::inscribed_radius() const { return 0.5 * std::min(length, width); }

double VehicleConfig::circumscribed_radius() const { return 0.5 * std::hypot(length, width); }

int ObservationSize(const Experiment& experiment) {
  const ObservationConfig& observation = experiment.observation;
  int size = 0;
  if (observation.position) size += 2;
  if (observation.heading) size += 2;
  if (observation.velocity) size += 2;
  if (observation.d_min) size += 1;
  if (observation.look_ahead) size += 4;
  if (observation.rays) size += experiment.vehicle.scan.beams;
  return size;
}

int EpisodeSteps(const Experiment& experiment, double max_cost) {
  const EnvironmentConfig& environment = experiment.environment;
  if (environment.max_episode_steps > 0) return environment.max_episode_steps;
  const double steps = std::ceil(6.0 * max_cost / (experiment.vehicle.max_speed * environment.control_period));
  return static_cast<int>(std::clamp(steps, 1.0, 1e6));
}

}  // namespace cairn
