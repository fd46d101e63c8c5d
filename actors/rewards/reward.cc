#include "actors/rewards/reward.h"

#include "actors/rewards/euclidean_reward.h"
#include "actors/rewards/graph_reward.h"
#include "common/core/check.h"

namespace cairn::actors {

float Reward::Evaluate(StepEvent event, float d_min, float distance) const {
  double reward = config_.step_reward;
  if (event == StepEvent::kObstacle) {
    reward += config_.collision_reward;
  } else if (event == StepEvent::kGoal) {
    reward += config_.goal_reward;
  } else if (pays_progress() && distance < d_min) {
    reward += config_.progress_reward;
  }
  return static_cast<float>(reward);
}

std::unique_ptr<Reward> MakeReward(const Experiment& experiment) {
  switch (experiment.reward.kind) {
    case RewardConfig::Kind::kGraph:
      return std::make_unique<GraphReward>(experiment.reward);
    case RewardConfig::Kind::kSparse:
      return std::make_unique<SparseReward>(experiment.reward);
    case RewardConfig::Kind::kEuclidean:
      return std::make_unique<EuclideanReward>(experiment.reward, experiment.planner.r_ball());
  }
  ThrowUsageError("reward.kind = {}: no such reward", static_cast<int>(experiment.reward.kind));
}

}  // namespace cairn::actors
