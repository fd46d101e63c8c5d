#include "learner/algorithms/batch.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"

namespace cairn::learner {
namespace {

// Measured on Zen 4 (32 kB of first-level cache): 128 columns of 64 and 32 of 256 are the best, by 1 to 2 %.
constexpr int kMaxChunk = 128;
constexpr int kSharedMaxChunk = 64;
constexpr int kMinChunk = 32;
constexpr int kActivationFloats = 8192;  // 32 kB: one layer's activations of one chunk
constexpr int kFloatsPerCacheLine = 16;

// Of a sleeping thread, and of both critics' and their targets' passes for one sample; measured on Zen 5 at 64x64.
constexpr double kWakeUpSeconds = 25e-6;
constexpr double kSecondsPerParameter = 7.5e-11;

constexpr size_t kRowsAhead = 24;

}  // namespace

Chunks::Chunks(int batch_size, int widest_layer, int shares, size_t parameters) : batch_size_(batch_size) {
  CAIRN_CHECK(batch_size > 0 && widest_layer > 0 && shares > 0);
  const int most = shares > 1 ? kSharedMaxChunk : kMaxChunk;
  const int limit = std::clamp(kActivationFloats / widest_layer, kMinChunk, most);
  const int pieces = (batch_size + limit - 1) / limit;
  chunk_ = (batch_size + pieces - 1) / pieces;
  shares_ = std::min(shares, count());
  first_share_ = shares_ == 1 ? count() : FirstShare(kSecondsPerParameter * chunk_ * static_cast<double>(parameters));
}

// All shares would end at once with `even` chunks in the first. With fewer the caller waits for the others and has to
// wake up itself, with more they wait for it.
int Chunks::FirstShare(double chunk_seconds) const {
  if (chunk_seconds == 0) return count() / shares_;
  const int others = shares_ - 1;
  const double wake_up = kWakeUpSeconds / chunk_seconds;  // in chunks
  const double even = (count() + others * wake_up) / shares_;
  const double fewer = std::floor(even), more = fewer + 1;
  const bool takes_more = more - even < (even - fewer) / others + wake_up;
  return static_cast<int>(std::min<double>(takes_more ? more : fewer, count() - others));
}

int Chunks::share_begin(int share) const {
  if (share == 0) return 0;
  if (share == shares_) return count();
  return first_share_ + (count() - first_share_) * (share - 1) / (shares_ - 1);
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
