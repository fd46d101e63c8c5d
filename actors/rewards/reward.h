#pragma once

#include <memory>

#include "actors/scene.h"

namespace cairn::actors {

/// What a control step ran into first.
enum class StepEvent { kNone, kObstacle, kGoal };

/// The augmented reward r̃ of (s, D_min), paper equation 2; kinds differ in what D is and whether progress pays.
/// Stateless: the environment keeps D_min, so that Save holds it.
class Reward {
 public:
  explicit Reward(const RewardConfig& config) : config_(config) {}
  virtual ~Reward() = default;

  /// D(s) at a position [m], kUnreachable where it has none. D_min is its minimum over the episode.
  virtual float Distance(const Scene& scene, const Vector3d& p) const = 0;

  /// Equation 2, cases exclusive and in this order: obstacle, goal, progress (`distance` < `d_min`, so also the first
  /// finite value), otherwise 0; plus step_reward always. `d_min` is from before the step, `distance` D at its end.
  float Evaluate(StepEvent event, float d_min, float distance) const;

 protected:
  virtual bool pays_progress() const { return true; }
  const RewardConfig& config() const { return config_; }

 private:
  RewardConfig config_;
};

/// The reward that the experiment asks for.
std::unique_ptr<Reward> MakeReward(const Experiment& experiment);

}  // namespace cairn::actors
