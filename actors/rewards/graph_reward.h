#pragma once

#include "actors/rewards/reward.h"

namespace cairn::actors {

/// The paper's reward: D(s) is the roadmap's cost-to-go within r_ball (Motion Planning Guided Reward).
class GraphReward : public Reward {
 public:
  using Reward::Reward;
  float Distance(const Scene& scene, const Vector3d& p) const override { return scene.lookup().CostToGo(p); }
};

/// R_- and R_++ only. D(s) is the roadmap's all the same, so that the observation means the same for both.
class SparseReward final : public GraphReward {
 public:
  using GraphReward::GraphReward;

 protected:
  bool pays_progress() const override { return false; }
};

}  // namespace cairn::actors
