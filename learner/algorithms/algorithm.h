#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/config/experiment.h"
#include "common/nn/policy.h"
#include "learner/algorithms/state_array.h"
#include "learner/replay/replay_buffer.h"

namespace cairn::learner {

/// Means over the updates since the last call, under Stable-Baselines3's names (train/…).
struct UpdateInfo {
  int64_t num_updates = 0;        ///< since start
  int64_t bad_updates = 0;        ///< of these, broken off at something that was not finite
  int64_t num_means = 0;          ///< since the last call, without bad ones; the means are over these
  int64_t num_actor_updates = 0;  ///< since the last call (TD3 delays them); actor_loss and SAC's values are over these
  double critic_loss = 0;
  double actor_loss = 0;
  double alpha = 0;       ///< entropy coefficient (SAC)
  double alpha_loss = 0;  ///< ent_coef_loss (SAC)
  double mean_q = 0;
  double mean_log_prob = 0;  ///< SAC
};

/// An off-policy algorithm behind one narrow interface: what it learns from, what it yields. One thread.
class Algorithm {
 public:
  virtual ~Algorithm() = default;

  /// Makes `count` updates from `replay` (not empty). `progress` in [0, 1] is the share of the run done, for schedules.
  /// An update ends at the first loss or gradient that is not finite, which is not applied, and is counted as bad. The
  /// critics come first: they have made their step when it is the policy's. Throws Error when max_bad_updates in a row
  /// are bad.
  virtual void Update(const ReplayBuffer& replay, int count, double progress) = 0;

  /// Current parameters of the policy in PolicyShape's order; valid until the next Update.
  virtual std::span<const float> policy_parameters() const = 0;

  /// Returns the means since the last call and starts new ones.
  virtual UpdateInfo TakeInfo() = 0;

  /// Everything that an interrupted run needs to go on with the same bits: weights, targets, moments, counters.
  virtual std::vector<StateArray> Save() = 0;

  /// Takes up what Save gave. Throws Error naming an array that is missing or has another size.
  virtual void Load(const std::vector<StateArray>& state) = 0;

  /// Takes the networks (and alpha) alone from another run's Save, with fresh optimizers. Throws as Load.
  virtual void LoadNetworks(const std::vector<StateArray>& state) = 0;

  /// CRC32C over every learnt parameter (policy, critics, targets, alpha): equal runs have equal values.
  virtual uint32_t WeightsCrc32c() const = 0;
};

/// SAC (Haarnoja et al. 2018, automatic temperature) or TD3 (Fujimoto et al. 2018) as the config says; weights and all
/// random choices come from `seed`.
std::unique_ptr<Algorithm> MakeAlgorithm(const LearnerConfig& config, const PolicyShape& shape, uint64_t seed);

}  // namespace cairn::learner
