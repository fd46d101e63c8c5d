#pragma once

#include "actors/rewards/reward.h"

namespace cairn::actors {

/// A baseline that sees no walls: D(s) is the straight-line distance to the goal region, counted in whole steps of
/// `step` [m] so that it pays about as often as the graph's.
class EuclideanReward final : public Reward {
 public:
  EuclideanReward(const RewardConfig& config, double step);
  float Distance(const Scene& scene, const Vector3d& p) const override;

 private:
  double step_;
};

}  // namespace cairn::actors
