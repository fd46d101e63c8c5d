#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "common/config/experiment.h"
#include "common/core/random.h"
#include "common/nn/policy.h"
#include "learner/algorithms/algorithm.h"
#include "learner/replay/replay_buffer.h"
#include "tests/learner/algorithms/pendulum.h"

namespace cairn::learner {

inline PolicyShape PendulumShape(const LearnerConfig& config) {
  PolicyShape shape;
  shape.head = config.algorithm == LearnerConfig::Algorithm::kSac ? PolicyShape::Head::kGaussian
                                                                  : PolicyShape::Head::kDeterministic;
  shape.observation_size = Pendulum::kObservationSize;
  shape.action_size = Pendulum::kActionSize;
  shape.net_arch = config.net_arch;
  return shape;
}

/// The settings with which SAC swings up within 10,000 steps; test and benchmark share them.
inline LearnerConfig PendulumSacConfig() {
  LearnerConfig config;
  config.net_arch = {64, 64};
  config.batch_size = 100;
  config.buffer_size = 10000;
  config.learning_starts = 100;
  config.n_steps = 1;
  config.initial_alpha = 1.0;
  config.target_entropy = -1;
  return config;
}

/// Policy, replay and algorithm on one pendulum, one update (of critics, policy and alpha) a step.
class PendulumRun {
 public:
  PendulumRun(const LearnerConfig& config, uint64_t seed)
      : config_(config),
        algorithm_(MakeAlgorithm(config, PendulumShape(config), seed)),
        replay_(config.buffer_size, 3, 1, config.n_steps, config.gamma),
        policy_(PendulumShape(config), 1),
        start_(seed, RandomPurpose::kStart),
        noise_(seed, RandomPurpose::kExploration) {}

  /// The first `learning_starts` steps are random and without updates.
  void Train(int steps) {
    for (int step = 0; step < steps; ++step) {
      if (step % Pendulum::kEpisodeSteps == 0) pendulum_.Reset(&start_);
      const bool last = step % Pendulum::kEpisodeSteps == Pendulum::kEpisodeSteps - 1;
      const auto observation = pendulum_.observation();
      const float action = Explore(observation, step);
      Segment segment;
      segment.observations.assign(observation.begin(), observation.end());
      segment.actions = {action};
      segment.rewards = {pendulum_.Step(action)};
      const auto next = pendulum_.observation();
      segment.observations.insert(segment.observations.end(), next.begin(), next.end());
      segment.end = last ? SegmentEnd::kTruncated : SegmentEnd::kNone;
      replay_.Insert(segment);
      if (step >= config_.learning_starts) algorithm_->Update(replay_, 1, static_cast<double>(step) / steps);
    }
  }

  /// Mean over episodes of the deterministic policy.
  double MeanReturn(int episodes) {
    policy_.SetParameters(algorithm_->policy_parameters());
    double sum = 0;
    for (int i = 0; i < episodes * Pendulum::kEpisodeSteps; ++i) {
      if (i % Pendulum::kEpisodeSteps == 0) pendulum_.Reset(&start_);
      float action;
      policy_.Act(pendulum_.observation().data(), 1, &action);
      sum += pendulum_.Step(action);
    }
    return sum / episodes;
  }

 private:
  float Explore(const std::array<float, 3>& observation, int step) {
    if (step < config_.learning_starts) return static_cast<float>(noise_.Uniform(-1.0, 1.0));
    policy_.SetParameters(algorithm_->policy_parameters());
    const auto normal = static_cast<float>(noise_.Normal());
    float action;
    policy_.Explore(observation.data(), 1, &normal, static_cast<float>(config_.action_noise), &action);
    return action;
  }

  LearnerConfig config_;
  std::unique_ptr<Algorithm> algorithm_;
  ReplayBuffer replay_;
  Policy policy_;
  Pendulum pendulum_;
  RandomStream start_, noise_;
};

}  // namespace cairn::learner
