#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace cairn {

/// Shape of a policy network: what its parameter vector means.
struct PolicyShape {
  enum class Head : int8_t {
    kGaussian = 0,       ///< SAC: outputs mean and log_std (clamped to [−20, 2]), action = tanh(mean + std · noise)
    kDeterministic = 1,  ///< TD3: outputs tanh(mean); exploration adds noise and clips to [−1, 1]
  };
  Head head = Head::kGaussian;
  int observation_size = 0;
  int action_size = 0;
  std::vector<int> net_arch;  ///< hidden layers, ReLU
  bool layer_norm = false;    ///< LayerNorm before each ReLU

  bool operator==(const PolicyShape&) const = default;
  int output_size() const { return head == Head::kGaussian ? 2 * action_size : action_size; }
  /// Per layer in order: W column-major [out × in], b [out], and in hidden layers with LayerNorm gain [out], bias
  /// [out].
  size_t num_parameters() const;
  /// One line for errors and logs: "gaussian 27-64-64-4".
  std::string ToString() const;
};

/// Inference of one policy for up to `max_batch` observations at a time. The result for one observation has the same
/// bits whatever its place in the batch and the batch's size. No allocation after construction. One thread.
class Policy {
 public:
  Policy(PolicyShape shape, int max_batch);
  ~Policy();
  Policy(Policy&&) noexcept;
  Policy& operator=(Policy&&) noexcept;

  /// Copies the parameters; throws Error when the size is not shape().num_parameters() or an entry is not finite.
  void SetParameters(std::span<const float> parameters);

  /// Deterministic actions: tanh(mean). `observations` is [n × observation_size], `actions` [n × action_size], one row
  /// per sample; n ≤ max_batch.
  void Act(const float* observations, int n, float* actions);

  /// Exploring actions. `noise` [n × action_size] holds standard normals; for kDeterministic heads `action_noise` is
  /// the standard deviation added before clipping (unused for kGaussian).
  void Explore(const float* observations, int n, const float* noise, float action_noise, float* actions);

  const PolicyShape& shape() const { return shape_; }

 private:
  struct Workspace;
  PolicyShape shape_;
  std::unique_ptr<Workspace> workspace_;
};

/// A policy at rest.
struct PolicyFile {
  PolicyShape shape;
  std::vector<float> parameters;
  int64_t version = 0;
  int64_t env_steps = 0;
  uint64_t experiment_hash = 0;
};

/// Writes beside, fsyncs, renames. Throws Error naming the path and the system's reason (disk full, …).
void SavePolicy(const PolicyFile& policy, const std::string& path);

/// Throws Error naming the path and what is wrong: missing, torn, CRC mismatch, other format version, sizes.
PolicyFile LoadPolicy(const std::string& path);

}  // namespace cairn
