#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/nn/aligned_buffer.h"
#include "learner/replay/replay_buffer.h"

namespace cairn::learner {

/// Adjacent samples of a batch.
struct Chunk {
  int first = 0;
  int size = 0;
};

/// How the samples of a batch are cut into the shares of threads, and these into chunks, for each of which the products
/// of the weights' gradients are made at once.
class Chunks {
 public:
  /// The first share is the caller's, which begins while the others wake up, and larger by that much. `parameters`,
  /// those of a critic, tell how long a sample takes.
  explicit Chunks(int batch_size, int shares = 1, size_t parameters = 0);

  /// At most as many as were asked for: fewer where shares would be too small for waking up another thread.
  int num_shares() const { return static_cast<int>(shares_.size()); }
  /// In ascending order, of nearly equal size.
  std::span<const Chunk> share(int share) const { return shares_[share]; }
  /// The sizes that occur, ascending.
  std::vector<int> sizes() const;

 private:
  std::vector<std::vector<Chunk>> shares_;
};

/// Floats from one sample of a batch to the next.
int BatchStride(int observation_size, int action_size);

/// Transitions of one update, one a column: observation | action | n-step return | discount | next observation | next
/// action. So the inputs of policy and critics, now and next, stand together and need no copies: the algorithms write
/// the actions that their policies choose into the columns.
template <typename Scalar>
class Batch {
 public:
  Batch(int size, int observation_size, int action_size);

  int size() const { return size_; }
  int observation_size() const { return observation_size_; }
  int action_size() const { return action_size_; }
  int stride() const { return stride_; }

  /// Input of policy (its first part) and critics.
  Scalar* input(int sample) { return columns_.data() + static_cast<size_t>(sample) * stride_; }
  Scalar* action(int sample) { return input(sample) + observation_size_; }
  Scalar& reward(int sample) { return input(sample)[observation_size_ + action_size_]; }
  Scalar& discount(int sample) { return input(sample)[observation_size_ + action_size_ + 1]; }
  Scalar* next_input(int sample) { return input(sample) + observation_size_ + action_size_ + 2; }
  Scalar* next_action(int sample) { return next_input(sample) + observation_size_; }

  /// Standard normals, one action dimension per column: [size × action_size].
  Scalar* noise() { return noise_.data(); }            ///< for the actions at the observations
  Scalar* next_noise() { return next_noise_.data(); }  ///< for the actions at the next observations

  /// Copies rows of `replay` to samples [first, first + count): sample i gets the one that rows[i] names, of rows
  /// [size].
  void Gather(const ReplayBuffer& replay, std::span<const uint32_t> rows, int first, int count);

 private:
  int size_, observation_size_, action_size_, stride_;
  AlignedBuffer<Scalar> columns_;
  AlignedBuffer<Scalar> noise_, next_noise_;
};

/// Completes a batch while it is used; any thread of the update may call it. The plain one does nothing: the batch is
/// complete.
class BatchFeeder {
 public:
  virtual ~BatchFeeder() = default;

  /// Called before samples [first, first + count) are used, once an update.
  virtual void Need(int /*first*/, int /*count*/) {}
};

extern template class Batch<float>;
extern template class Batch<double>;

}  // namespace cairn::learner
