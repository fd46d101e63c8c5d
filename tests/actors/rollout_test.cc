#include "actors/rollout.h"

#include <gtest/gtest.h>

#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

PolicyShape Shape(const Experiment& experiment) {
  PolicyShape shape;
  shape.observation_size = ObservationSize(experiment);
  shape.action_size = kCarActions;
  shape.net_arch = {16};
  return shape;
}

Policy MakePolicy(const Experiment& experiment) {
  const PolicyShape shape = Shape(experiment);
  std::vector<float> parameters(shape.num_parameters());
  RandomStream random(5, RandomPurpose::kTest);
  for (float& p : parameters) p = static_cast<float>(0.3 * random.Normal());
  Policy policy(shape, 8);
  policy.SetParameters(parameters);
  return policy;
}

RolloutContext Context(Policy* policy, bool warm_up = false) { return {policy, warm_up, 21, 22}; }

// Every segment of a vehicle, joined; checks that they continue each other.
struct Way {
  std::vector<float> observations, actions, rewards;
  std::vector<int> ends;
};
Way Join(const std::vector<Segment>& segments, int vehicle) {
  Way way;
  int episode = 0, step = 0;
  for (const Segment& s : segments) {
    if (s.vehicle != vehicle) continue;
    EXPECT_EQ(s.episode, episode);
    EXPECT_EQ(s.first_step, step);
    EXPECT_EQ(s.policy_incarnation, 21);
    EXPECT_EQ(s.policy_version, 22);
    EXPECT_NE(s.table_hash, 0u);
    step = s.end == SegmentEnd::kNone ? step + s.num_steps() : 0;
    episode += s.end == SegmentEnd::kNone ? 0 : 1;
    if (s.end != SegmentEnd::kNone) way.ends.push_back(static_cast<int>(way.rewards.size()) + s.num_steps());
    way.observations.insert(way.observations.end(), s.observations.begin(), s.observations.end());
    way.actions.insert(way.actions.end(), s.actions.begin(), s.actions.end());
    way.rewards.insert(way.rewards.end(), s.rewards.begin(), s.rewards.end());
  }
  return way;
}

TEST(RolloutTest, WhatAVehicleDoesDoesNotDependOnItsCompany) {
  const Experiment experiment = NoisyMazeExperiment();
  const auto scene = MakeScene(experiment);
  Policy policy = MakePolicy(experiment);
  Rollout all(scene), one(scene);
  all.Assign({0, 1, 2}, {0, 0, 0}, {0, 0, 0});
  one.Assign({1}, {0}, {0});
  for (int i = 0; i < 400; ++i) {
    all.Step({0, 1, 2}, Context(&policy));
    one.Step({0}, Context(&policy));
  }
  const Way a = Join(all.TakeSegments(), 1), b = Join(one.TakeSegments(), 1);
  EXPECT_EQ(a.observations, b.observations);
  EXPECT_EQ(a.actions, b.actions);
  EXPECT_EQ(a.rewards, b.rewards);
  EXPECT_EQ(a.ends, b.ends);
  EXPECT_EQ(a.rewards.size(), 400u);
  EXPECT_FALSE(a.ends.empty()) << "the test should see an episode end";
}

TEST(RolloutTest, TakingSegmentsInBetweenLosesAndDoublesNothing) {
  const Experiment experiment = NoisyMazeExperiment();
  const auto scene = MakeScene(experiment);
  Policy policy = MakePolicy(experiment);
  Rollout whole(scene), pieces(scene);
  whole.Assign({0}, {0}, {0});
  pieces.Assign({0}, {0}, {0});
  std::vector<Segment> taken;
  for (int i = 0; i < 60; ++i) {
    whole.Step({0}, Context(&policy));
    pieces.Step({0}, Context(&policy));
    if (i % 7 != 0) continue;
    for (Segment& s : pieces.TakeSegments()) taken.push_back(std::move(s));
  }
  for (Segment& s : pieces.TakeSegments()) taken.push_back(std::move(s));
  EXPECT_TRUE(pieces.TakeSegments().empty());
  const Way a = Join(whole.TakeSegments(), 0), b = Join(taken, 0);
  EXPECT_EQ(a.actions, b.actions);
  EXPECT_EQ(a.rewards, b.rewards);
  EXPECT_EQ(a.ends, b.ends);
}

TEST(RolloutTest, WarmUpDrawsUniformActionsThatThePolicyDoesNotTouch) {
  const Experiment experiment;
  const auto scene = MakeScene(experiment);
  Rollout rollout(scene);
  rollout.Assign({0, 1}, {0, 0}, {0, 0});
  for (int i = 0; i < 200; ++i) rollout.Step({0, 1}, Context(nullptr, true));
  double sum = 0, square = 0;
  int n = 0;
  for (const Segment& s : rollout.TakeSegments()) {
    for (const float a : s.actions) {
      EXPECT_LE(std::abs(a), 1.0f);
      sum += a;
      square += a * a;
      ++n;
    }
  }
  ASSERT_EQ(n, 800);
  EXPECT_NEAR(sum / n, 0, 0.1);            // standard error 0.02
  EXPECT_NEAR(square / n, 1.0 / 3, 0.05);  // of a uniform draw
}

TEST(RolloutTest, CountsOnFromWhatTheLearnerHas) {
  const Experiment experiment;
  const auto scene = MakeScene(experiment);
  Rollout rollout(scene);
  rollout.Assign({4, 6}, {2, 0}, {30, 0});
  EXPECT_EQ(rollout.transitions(0), 30);
  rollout.Step({0}, Context(nullptr, true));
  EXPECT_EQ(rollout.transitions(0), 31);
  EXPECT_EQ(rollout.env_steps(), 1);
  const std::vector<Segment> segments = rollout.TakeSegments();
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].vehicle, 4);
  EXPECT_EQ(segments[0].episode, 2);
  // One that stays knows better than the learner, whose count lags behind.
  rollout.Assign({4, 5}, {9, 1}, {7, 8});
  EXPECT_EQ(rollout.transitions(0), 31);
  EXPECT_EQ(rollout.transitions(1), 8);
}

// A small hall and random actions: many collisions, some time-outs.
TEST(RolloutTest, AStartIsTriedAgainOnlyAfterACollisionAndAsOftenAsAsked) {
  Experiment experiment = HallExperiment();
  experiment.world.goal = {{1.45, 0.45, 0}, {1.55, 0.55, 0}};
  experiment.environment.max_episode_steps = 15;  // so that some end without a collision
  for (const double share : {0.0, 0.9}) {
    experiment.environment.retry_failed_start = share;
    const auto scene = MakeScene(experiment);
    Rollout rollout(scene);
    rollout.Assign({0}, {0}, {0});
    int again = 0, after_collision = 0, after_others = 0;
    Outcome last = Outcome::kRunning;
    std::array<float, 2> start{};
    const auto position = [&] {
      const Pose pose = rollout.first()->pose();
      return std::array<float, 2>{static_cast<float>(pose.x), static_cast<float>(pose.y)};
    };
    start = position();
    for (int i = 0; i < 20000 && after_collision < 100; ++i) {
      rollout.Step({0}, Context(nullptr, true));
      for (const EpisodeResult& episode : rollout.TakeEpisodes()) {
        last = episode.outcome;
        const bool same = position() == start;
        if (last == Outcome::kCollision) {
          ++after_collision;
          again += same;
        } else {
          ++after_others;
          EXPECT_FALSE(same);
        }
        start = position();
      }
    }
    ASSERT_EQ(after_collision, 100);
    EXPECT_GT(after_others, 0);
    EXPECT_NEAR(again, 100 * share, share == 0 ? 0 : 10);  // standard deviation 3
  }
}

}  // namespace
}  // namespace cairn::actors
