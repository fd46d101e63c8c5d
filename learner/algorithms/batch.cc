#include "learner/algorithms/batch.h"

#include <algorithm>

#include "common/core/check.h"

namespace cairn::learner {
namespace {

// Measured on Zen 4 (32 kB of first-level cache): 128 columns of 64 and 32 of 256 are the best, by 1 to 2 %.
constexpr int kMaxChunk = 128;
constexpr int kMinChunk = 32;
constexpr int kActivationFloats = 8192;  // 32 kB: one layer's activations of one chunk
constexpr int kFloatsPerCacheLine = 16;
constexpr size_t kRowsAhead = 16;

}  // namespace

Chunks::Chunks(int batch_size, int widest_layer) : batch_size_(batch_size) {
  CAIRN_CHECK(batch_size > 0 && widest_layer > 0);
  const int limit = std::clamp(kActivationFloats / widest_layer, kMinChunk, kMaxChunk);
  const int count = (batch_size + limit - 1) / limit;
  chunk_ = (batch_size + count - 1) / count;
}

std::vector<int> Chunks::sizes() const {
  const int last = size(count() - 1);
  return last == chunk_ ? std::vector<int>{chunk_} : std::vector<int>{last, chunk_};
}

int BatchStride(int observation_size, int action_size) {
  const int used = 2 * (observation_size + action_size + 1);
  return (used + kFloatsPerCacheLine - 1) / kFloatsPerCacheLine * kFloatsPerCacheLine;
}

template <typename Scalar>
Batch<Scalar>::Batch(int size, int observation_size, int action_size)
    : size_(size),
      observation_size_(observation_size),
      action_size_(action_size),
      stride_(BatchStride(observation_size, action_size)) {
  columns_ = AlignedBuffer<Scalar>(static_cast<size_t>(size) * stride_);
  noise_ = AlignedBuffer<Scalar>(static_cast<size_t>(size) * action_size);
  next_noise_ = AlignedBuffer<Scalar>(static_cast<size_t>(size) * action_size);
}

template <typename Scalar>
void Batch<Scalar>::Gather(const ReplayBuffer& replay, std::span<const uint32_t> rows, int first) {
  CAIRN_DCHECK(replay.observation_size() == observation_size_ && replay.action_size() == action_size_);
  // A replay row is a column without its last part; whole cache lines are copied.
  const int floats = std::min(replay.row_floats(), stride_);
  Scalar* column = input(first);
  for (size_t r = 0; r < rows.size(); ++r) {
    // They were asked for a chunk ago; what has left the first-level cache since then comes back meanwhile.
    if (r + kRowsAhead < rows.size()) replay.Prefetch(static_cast<int>(rows[r + kRowsAhead]));
    const float* row = replay.row(static_cast<int>(rows[r]));
    for (int i = 0; i < floats; i += kFloatsPerCacheLine) {
      for (int k = i; k < i + kFloatsPerCacheLine; ++k) column[k] = static_cast<Scalar>(row[k]);
    }
    column += stride_;
  }
}

template class Batch<float>;
template class Batch<double>;

}  // namespace cairn::learner
