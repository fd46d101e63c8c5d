#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/nn/aligned_buffer.h"
#include "learner/replay/replay_buffer.h"

namespace cairn::learner {

/// How the samples of a batch are cut into pieces that stay in the first-level cache all through the layers, and these
/// into the shares of threads.
class Chunks {
 public:
  /// Pieces of nearly equal size, at most about `kActivationFloats` floats of the widest layer each, smaller ones for
  /// several shares. `parameters`, those of a critic, tell how long a piece takes.
  Chunks(int batch_size, int widest_layer, int shares = 1, size_t parameters = 0);

  int count() const { return (batch_size_ + chunk_ - 1) / chunk_; }
  int first(int c) const { return c * chunk_; }
  int size(int c) const { return c + 1 < count() ? chunk_ : batch_size_ - first(c); }
  /// At most as many as were asked for: none is empty.
  int num_shares() const { return shares_; }
  /// Where a share begins; the last one ends at share_begin(num_shares()). The first is the caller's, which begins
  /// while the others wake up, and larger by that much.
  int share_begin(int share) const;
  /// The sizes that occur, ascending.
  std::vector<int> sizes() const;

 private:
  int FirstShare(double chunk_seconds) const;

  int batch_size_;
  int chunk_;
  int shares_;
  int first_share_;  // of chunks
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

  /// Copies the rows of `replay` that `rows` names to the samples from `first` on.
  void Gather(const ReplayBuffer& replay, std::span<const uint32_t> rows, int first);

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

  /// Samples [first, first + count) of this batch, or of the next one, will be needed after those of the next Need.
  virtual void Expect(int /*first*/, int /*count*/, bool /*of_next_batch*/) {}

  /// Called before samples [first, first + count) are used, once an update.
  virtual void Need(int /*first*/, int /*count*/) {}
};

extern template class Batch<float>;
extern template class Batch<double>;

}  // namespace cairn::learner
