#include "actors/episode_meter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "actors/clearance.h"

namespace cairn::actors {

namespace {
// Between two looks a vehicle braking or turning at 10 m/s² changes its clearance by a few tenths of a millimetre
// more than the looks see; looking every physics step took a quarter of the plane car's time.
constexpr double kClearanceRateHz = 60;
}  // namespace

EpisodeMeter::EpisodeMeter(const Scene& scene, const ContactTest& contact)
    : scene_(scene),
      contact_(contact),
      time_step_(1.0 / scene.experiment().environment.physics_rate_hz),
      control_period_(scene.control_physics_steps() * time_step_),
      clearance_stride_(
          std::max<int64_t>(1, std::llround(scene.experiment().environment.physics_rate_hz / kClearanceRateHz))) {}

void EpisodeMeter::Reset(const Motion& start) {
  numbers_ = Numbers{};
  numbers_.x = start.x;
  numbers_.y = start.y;
  numbers_.z = start.z;
  numbers_.min_clearance = std::numeric_limits<double>::infinity();
  MeasureClearance(start, contact_.CenterDistance(start));
}

void EpisodeMeter::AddPhysicsStep(const Motion& motion, double center_distance) {
  Numbers& n = numbers_;
  const double dx = motion.x - n.x, dy = motion.y - n.y, dz = motion.z - n.z;
  n.path_length += std::sqrt(dx * dx + dy * dy + dz * dz);
  n.x = motion.x;
  n.y = motion.y;
  n.z = motion.z;
  ++n.physics_steps;
  if (n.physics_steps % clearance_stride_ == 0) MeasureClearance(motion, center_distance);
}

void EpisodeMeter::MeasureClearance(const Motion& motion, double center_distance) {
  Numbers& n = numbers_;
  if (center_distance - contact_.footprint().circumscribed_radius() >= n.min_clearance) return;
  n.min_clearance =
      FootprintClearance(scene_.field(), motion.pose(), contact_.footprint(), center_distance, n.min_clearance);
  n.min_clearance = contact_.PersonClearance(motion, n.min_clearance);
}

// Jerk by second differences of the velocity in W: |v_k − 2 v_{k−1} + v_{k−2}| / period², from the second step on.
void EpisodeMeter::AddControlStep(const Motion& motion) {
  Numbers& n = numbers_;
  const double c = std::cos(motion.yaw), s = std::sin(motion.yaw);
  const double velocity[3] = {c * motion.vx - s * motion.vy, s * motion.vx + c * motion.vy, motion.vz};
  ++n.control_steps;
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    const double change = velocity[k] - 2 * n.velocity[0][k] + n.velocity[1][k];
    squared += change * change;
    n.velocity[1][k] = n.velocity[0][k];
    n.velocity[0][k] = velocity[k];
  }
  if (n.control_steps >= 2) n.jerk_sum += std::sqrt(squared) / (control_period_ * control_period_);
}

void EpisodeMeter::Fill(EpisodeResult& result) const {
  const Numbers& n = numbers_;
  result.path_length = static_cast<float>(n.path_length);
  result.min_clearance = static_cast<float>(n.min_clearance);
  result.mean_jerk =
      n.control_steps >= 2 ? static_cast<float>(n.jerk_sum / static_cast<double>(n.control_steps - 1)) : 0;
  result.filtered_steps = static_cast<int32_t>(n.filtered_steps);
  result.duration = static_cast<float>(static_cast<double>(n.physics_steps) * time_step_);
}

}  // namespace cairn::actors
