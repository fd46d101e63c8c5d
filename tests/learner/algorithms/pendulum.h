#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/core/random.h"

namespace cairn::learner {

/// Gymnasium's Pendulum-v1 with its equations and constants: swing a rod up and hold it. Observation cos θ, sin θ, θ̇;
/// action in [−1, 1] is the torque over 2 N·m; episodes are truncated after 200 steps.
class Pendulum {
 public:
  static constexpr int kObservationSize = 3;
  static constexpr int kActionSize = 1;
  static constexpr int kEpisodeSteps = 200;

  void Reset(RandomStream* random) {
    angle_ = random->Uniform(-std::numbers::pi, std::numbers::pi);
    velocity_ = random->Uniform(-1.0, 1.0);
  }

  std::array<float, 3> observation() const {
    return {static_cast<float>(std::cos(angle_)), static_cast<float>(std::sin(angle_)), static_cast<float>(velocity_)};
  }

  /// Returns the reward.
  float Step(float action) {
    constexpr double kGravity = 10.0, kMass = 1.0, kLength = 1.0, kTimeStep = 0.05;
    const double torque = 2.0 * std::clamp(static_cast<double>(action), -1.0, 1.0);
    const double from_top = std::remainder(angle_, 2 * std::numbers::pi);
    const double cost = from_top * from_top + 0.1 * velocity_ * velocity_ + 0.001 * torque * torque;
    velocity_ += (1.5 * kGravity / kLength * std::sin(angle_) + 3.0 / (kMass * kLength * kLength) * torque) * kTimeStep;
    velocity_ = std::clamp(velocity_, -8.0, 8.0);
    angle_ += velocity_ * kTimeStep;
    return static_cast<float>(-cost);
  }

 private:
  double angle_ = 0, velocity_ = 0;
};

}  // namespace cairn::learner
