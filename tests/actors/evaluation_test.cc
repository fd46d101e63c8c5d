#include "actors/evaluation.h"

#include <gtest/gtest.h>

#include <cstring>

#include "actors/controllers/policy_controller.h"
#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

// Ahead at a speed that depends on the heading: enough to end in many ways.
class Wanderer final : public Controller {
 public:
  void Act(std::span<const Environment* const> environments, float* actions) override {
    largest_batch = std::max(largest_batch, environments.size());
    for (const Environment* environment : environments) {
      *actions++ = static_cast<float>(std::sin(environment->pose().yaw));
      *actions++ = static_cast<float>(std::cos(3 * environment->pose().x));
    }
  }
  size_t largest_batch = 0;
};

void ExpectSame(const EpisodeResult& a, const EpisodeResult& b) {
  EXPECT_EQ(a.set, b.set);
  EXPECT_EQ(a.vehicle, b.vehicle);
  EXPECT_EQ(a.episode, b.episode);
  EXPECT_EQ(a.steps, b.steps);
  EXPECT_EQ(a.outcome, b.outcome);
  EXPECT_EQ(a.policy_version, b.policy_version);
  EXPECT_EQ(a.episode_return, b.episode_return);
  EXPECT_EQ(a.path_length, b.path_length);
  EXPECT_EQ(a.min_clearance, b.min_clearance);
  EXPECT_EQ(a.mean_jerk, b.mean_jerk);
}

TEST(EvaluationTest, ResultsDoNotDependOnTheBatch) {
  const auto scene = MakeScene(NoisyMazeExperiment());
  Wanderer wanderer;
  EvaluationOptions options;
  options.evaluation = 3;
  options.policy_version = 17;
  options.max_batch = 1;
  const auto one = RunEpisodes(scene, StartSet::kTest, AllStarts(20), wanderer, options);
  EXPECT_EQ(wanderer.largest_batch, 1u);
  options.max_batch = 7;
  const auto seven = RunEpisodes(scene, StartSet::kTest, AllStarts(20), wanderer, options);
  EXPECT_EQ(wanderer.largest_batch, 7u);
  ASSERT_EQ(one.size(), 20u);
  ASSERT_EQ(seven.size(), 20u);
  for (size_t i = 0; i < one.size(); ++i) {
    ExpectSame(one[i], seven[i]);
    EXPECT_EQ(one[i].vehicle, static_cast<int>(i));
    EXPECT_EQ(one[i].episode, 3);
    EXPECT_EQ(one[i].policy_version, 17);
    EXPECT_NE(one[i].outcome, Outcome::kRunning);
  }
}

TEST(EvaluationTest, KeepsTheOrderOfTheStarts) {
  const auto scene = MakeScene(Experiment{});
  Wanderer wanderer;
  const auto results = RunEpisodes(scene, StartSet::kValidation, {9, 2, 30}, wanderer);
  ASSERT_EQ(results.size(), 3u);
  EXPECT_EQ(results[0].vehicle, 9);
  EXPECT_EQ(results[1].vehicle, 2);
  EXPECT_EQ(results[2].vehicle, 30);
  EXPECT_EQ(results[1].set, StartSet::kValidation);
}

TEST(EvaluationTest, TrajectoriesBeginAtTheStartAndHaveAPointPerStep) {
  const auto scene = MakeScene(Experiment{});
  Wanderer wanderer;
  std::vector<Trajectory> trajectories;
  const auto results = RunEpisodes(scene, StartSet::kTest, AllStarts(5), wanderer, {}, &trajectories);
  ASSERT_EQ(trajectories.size(), 5u);
  for (int i = 0; i < 5; ++i) {
    const Trajectory& trajectory = trajectories[static_cast<size_t>(i)];
    const Pose start = scene->EvaluationStart(StartSet::kTest, i);
    ASSERT_EQ(trajectory.size(), static_cast<size_t>(results[static_cast<size_t>(i)].steps) + 1);
    EXPECT_FLOAT_EQ(trajectory[0][0], static_cast<float>(start.x));
    EXPECT_FLOAT_EQ(trajectory[0][1], static_cast<float>(start.y));
  }
}

TEST(EvaluationTest, PosesOfTheCallersTakeThePlaceOfTheSets) {
  const auto scene = MakeScene(HallExperiment());
  Wanderer wanderer;
  EvaluationOptions options;
  options.poses = {{0.2, 0.5, 1.5}, {2.0, 0.25, -1.0}};
  std::vector<Trajectory> trajectories;
  const auto results = RunEpisodes(scene, StartSet::kTest, {1, 0}, wanderer, options, &trajectories);
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(trajectories[0].front(), (std::array<float, 3>{2.0f, 0.25f, 0}));
  EXPECT_EQ(trajectories[1].front(), (std::array<float, 3>{0.2f, 0.5f, 0}));
  EXPECT_EQ(results[0].vehicle, 1);
}

TEST(EvaluationTest, NoStartsNoResults) {
  const auto scene = MakeScene(Experiment{});
  Wanderer wanderer;
  EXPECT_TRUE(RunEpisodes(scene, StartSet::kTest, {}, wanderer).empty());
}

// The controller must feed the network each vehicle's own observation: same actions one by one.
TEST(PolicyControllerTest, ActsOnEachEnvironmentsObservation) {
  const Experiment experiment;
  const auto scene = MakeScene(experiment);
  PolicyShape shape;
  shape.observation_size = ObservationSize(experiment);
  shape.action_size = kCarActions;
  shape.net_arch = {16};
  std::vector<float> parameters(shape.num_parameters());
  RandomStream random(5, RandomPurpose::kTest);
  for (float& p : parameters) p = static_cast<float>(0.3 * random.Normal());
  Policy policy(shape, 4);
  policy.SetParameters(parameters);
  PolicyController controller(policy, 4);
  std::vector<std::unique_ptr<Environment>> environments;
  std::vector<const Environment*> pointers;
  for (int i = 0; i < 3; ++i) {
    environments.push_back(std::make_unique<Environment>(scene));
    environments.back()->ResetTraining(i, 0);
    pointers.push_back(environments.back().get());
  }
  float actions[3 * kCarActions];
  controller.Act(pointers, actions);
  for (size_t i = 0; i < 3; ++i) {
    std::vector<float> observation(static_cast<size_t>(shape.observation_size));
    environments[i]->Observe(observation.data());
    float expected[kCarActions];
    policy.Act(observation.data(), 1, expected);
    EXPECT_EQ(std::memcmp(expected, actions + i * kCarActions, sizeof(expected)), 0);
  }
}

}  // namespace
}  // namespace cairn::actors
