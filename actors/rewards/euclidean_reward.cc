#include "actors/rewards/euclidean_reward.h"

#include <cmath>

#include "common/core/check.h"

namespace cairn::actors {

EuclideanReward::EuclideanReward(const RewardConfig& config, double step) : Reward(config), step_(step) {
  CAIRN_CHECK(step > 0);
}

float EuclideanReward::Distance(const Scene& scene, const Vector3d& p) const {
  Vector3d gap = (scene.goal().min - p).cwiseMax(p - scene.goal().max).cwiseMax(0.0);
  if (scene.world().dimension == 2) gap.z() = 0;
  return static_cast<float>(step_ * std::ceil(gap.norm() / step_));
}

}  // namespace cairn::actors
