#include "actors/localization.h"

#include <cmath>

namespace cairn::actors {
namespace {

// 32-bit numbers of a step: whether to jump (2), jump (8), noise (8).
constexpr uint64_t kDrawsPerStep = 32, kNoiseDraw = 16;

}  // namespace

Localization::Localization(const Experiment& experiment)
    : config_(experiment.observation),
      dimension_(experiment.vehicle.dimension()),
      jump_probability_(-std::expm1(-experiment.environment.control_period / config_.pose_jump_interval)),
      noisy_(config_.pose_noise > 0 || config_.heading_noise > 0),
      jumps_(config_.pose_jump > 0 || config_.heading_jump > 0),
      random_(0, RandomPurpose::kLocalization) {}

void Localization::Reset(const RandomStream& random) {
  random_ = random;
  offset_.fill(0);
  filtered_ = Measure(0);
}

void Localization::Advance(int step) {
  if (jumps_) {
    random_.SetPosition(static_cast<uint64_t>(step) * kDrawsPerStep);
    if (random_.Uniform() < jump_probability_) {
      for (int k = 0; k < 3; ++k) offset_[k] = k < dimension_ ? config_.pose_jump * random_.Normal() : 0;
      offset_[3] = config_.heading_jump * random_.Normal();
    }
  }
  if (config_.pose_filter == 0) return;
  // The last belief moves on by what odometry says, which is true: its error stays.
  const Error measured = Measure(step);
  for (size_t k = 0; k < filtered_.size(); ++k) {
    filtered_[k] = config_.pose_filter * filtered_[k] + (1 - config_.pose_filter) * measured[k];
  }
}

// Error of what is measured at the end of a step.
Localization::Error Localization::Measure(int step) const {
  RandomStream random = random_;
  random.SetPosition(static_cast<uint64_t>(step) * kDrawsPerStep + kNoiseDraw);
  Error error = offset_;
  for (int k = 0; k < dimension_; ++k) error[k] += config_.pose_noise * random.Normal();
  error[3] += config_.heading_noise * random.Normal();
  return error;
}

Pose Localization::Believe(const Pose& pose, int step) const {
  if (!active()) return pose;
  const Error error = config_.pose_filter > 0 ? filtered_ : Measure(step);
  return {pose.x + error[0], pose.y + error[1], pose.yaw + error[3], pose.z + error[2]};
}

}  // namespace cairn::actors
