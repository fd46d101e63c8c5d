#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "common/nn/gemm.h"
#include "learner/algorithms/batch.h"

namespace cairn::learner {

/// The threads that share the arithmetic of an update: the caller's and size − 1 others, which sleep in between and
/// never spin, so that a core that is taken costs no more than its share. Used by one thread.
class UpdateTeam {
 public:
  explicit UpdateTeam(int size);

  int size() const { return size_; }

  /// Calls f(0), …, f(size − 1), once each and at once if all threads get a core, and returns when all have returned.
  /// The caller begins with f(0); which thread has which other is open: it takes those that no other has begun, so that
  /// it does not wait for one that gets no core. f must not throw.
  template <typename F>
  void Run(F&& f) {
    Run([](void* context, int share) { (*static_cast<F*>(context))(share); }, &f);
  }

 private:
  using Function = void (*)(void* context, int share);
  void Run(Function function, void* context);
  void Help(const std::stop_token& stop);
  void TakeShares(std::unique_lock<std::mutex>* lock);

  int size_;
  std::mutex mutex_;  // of what stands between here and threads_
  std::condition_variable_any start_;
  std::condition_variable done_;
  Function function_ = nullptr;
  void* context_ = nullptr;
  int next_share_;                     // the first that nobody has begun; size_ when there is none
  int unfinished_ = 0;                 // shares that have not returned
  std::vector<std::jthread> threads_;  // last: they end before what they use
};

/// Calls f(first, n, accumulate, work) for all chunks of a batch, after the feeder has been asked for their samples:
/// each of the team's shares is adjacent ones in ascending order, with its own of `works`, and `accumulate` tells its
/// first from the others. So sums do not depend on which thread has which share.
template <typename Work, typename F>
void ForChunks(UpdateTeam* team, const Chunks& chunks, BatchFeeder* feeder, std::vector<Work>* works, F f) {
  team->Run([&](int share) {
    Accumulate accumulate = Accumulate::kOverwrite;
    for (const Chunk& chunk : chunks.share(share)) {
      feeder->Need(chunk.first, chunk.size);
      f(chunk.first, chunk.size, accumulate, &(*works)[share]);
      accumulate = Accumulate::kAdd;
    }
  });
}

}  // namespace cairn::learner
