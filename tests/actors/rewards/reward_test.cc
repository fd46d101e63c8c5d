#include "actors/rewards/reward.h"

#include <gtest/gtest.h>

#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

std::unique_ptr<Reward> Make(RewardConfig::Kind kind, double step_reward = 0) {
  Experiment experiment;
  experiment.reward.kind = kind;
  experiment.reward.progress_reward = 1;
  experiment.reward.goal_reward = 10;
  experiment.reward.collision_reward = -2;
  experiment.reward.step_reward = step_reward;
  return MakeReward(experiment);
}

TEST(RewardTest, CasesOfEquationTwoInOrder) {
  const auto reward = Make(RewardConfig::Kind::kGraph);
  EXPECT_EQ(reward->Evaluate(StepEvent::kNone, 1.0f, 1.0f), 0);   // no drop
  EXPECT_EQ(reward->Evaluate(StepEvent::kNone, 1.0f, 1.5f), 0);   // farther
  EXPECT_EQ(reward->Evaluate(StepEvent::kNone, 1.0f, 0.9f), 1);   // a drop
  EXPECT_EQ(reward->Evaluate(StepEvent::kNone, 1.0f, 0.01f), 1);  // of any size
  EXPECT_EQ(reward->Evaluate(StepEvent::kGoal, 1.0f, 0.9f), 10);  // goal instead of progress
  EXPECT_EQ(reward->Evaluate(StepEvent::kObstacle, 1.0f, 0.9f), -2);
}

TEST(RewardTest, InfiniteToFiniteCountsAsADrop) {
  const auto reward = Make(RewardConfig::Kind::kGraph);
  EXPECT_EQ(reward->Evaluate(StepEvent::kNone, kUnreachable, 5.0f), 1);
  EXPECT_EQ(reward->Evaluate(StepEvent::kNone, kUnreachable, kUnreachable), 0);
  EXPECT_EQ(reward->Evaluate(StepEvent::kNone, 5.0f, kUnreachable), 0);
}

TEST(RewardTest, StepRewardIsAddedToEveryStep) {
  const auto reward = Make(RewardConfig::Kind::kGraph, -0.25);
  EXPECT_EQ(reward->Evaluate(StepEvent::kNone, 1.0f, 1.0f), -0.25f);
  EXPECT_EQ(reward->Evaluate(StepEvent::kNone, 1.0f, 0.9f), 0.75f);
  EXPECT_EQ(reward->Evaluate(StepEvent::kGoal, 1.0f, 0.9f), 9.75f);
  EXPECT_EQ(reward->Evaluate(StepEvent::kObstacle, 1.0f, 0.9f), -2.25f);
}

TEST(RewardTest, SparsePaysEventsOnly) {
  const auto reward = Make(RewardConfig::Kind::kSparse);
  EXPECT_EQ(reward->Evaluate(StepEvent::kNone, 1.0f, 0.5f), 0);
  EXPECT_EQ(reward->Evaluate(StepEvent::kGoal, 1.0f, 0.5f), 10);
  EXPECT_EQ(reward->Evaluate(StepEvent::kObstacle, 1.0f, 0.5f), -2);
}

TEST(RewardTest, GraphAndSparseReadTheRoadmap) {
  const Experiment experiment = HallExperiment();
  Scene scene(experiment);
  scene.SetTable(MakeChain(scene.world().goal, {0.5f, 1.5f, 2.7f}, 0.5f, 0.05));
  for (const auto kind : {RewardConfig::Kind::kGraph, RewardConfig::Kind::kSparse}) {
    const auto reward = Make(kind);
    EXPECT_NEAR(reward->Distance(scene, Vector3d(1.52, 0.5, 0)), 1.2, 1e-6);
    EXPECT_EQ(reward->Distance(scene, Vector3d(1.0, 0.5, 0)), kUnreachable);
  }
}

// Goal region x 2.6…2.9, y 0.3…0.7; steps of eta / 2 = 0.05 m, counted upwards.
TEST(RewardTest, EuclideanCountsTheStraightLineInSteps) {
  Experiment experiment = HallExperiment();
  experiment.reward.kind = RewardConfig::Kind::kEuclidean;
  experiment.planner.eta = 0.1;
  const Scene scene(experiment);
  const auto reward = MakeReward(experiment);
  EXPECT_NEAR(reward->Distance(scene, Vector3d(2.57, 0.5, 0)), 0.05, 1e-6);
  EXPECT_NEAR(reward->Distance(scene, Vector3d(2.53, 0.5, 0)), 0.10, 1e-6);
  EXPECT_NEAR(reward->Distance(scene, Vector3d(2.3, 0.0, 0)), 0.45, 1e-6);  // √(0.3² + 0.3²) = 0.4243
  EXPECT_EQ(reward->Distance(scene, Vector3d(2.7, 0.5, 0)), 0);
}

}  // namespace
}  // namespace cairn::actors
