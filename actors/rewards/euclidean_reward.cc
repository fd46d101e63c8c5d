#include "actors/rewards/euclidean_reward.h"

#include <cmath>

#include "common/core/check.h"

namespace cairn::actors {

EuclideanReward::EuclideanReward(const RewardConfig& config, double step) : Reward(config), step_(step) {
  CAIRN_CHECK(step > 0);
}

float EuclideanReward::Distance(const Scene& scene, const Vector3d& p) const {
  const World& world = scene.world();
  Vector3d gap = (world.goal.min - p).cwiseMax(p - world.goal.max).cwiseMax(0.0);
  if (world.dimension == 2) gap.z() = 0;
  return static_cast<float>(step_ * std::ceil(gap.norm() / step_));
}

}  // namespace cairn::actors
