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

  /// Calls f(0), …, f(size − 1) at once, f(0) on the caller's thread, and returns when all have returned. f must not
  /// throw.
  template <typename F>
  void Run(F&& f) {
    Run([](void* context, int member) { (*static_cast<F*>(context))(member); }, &f);
  }

 private:
  using Function = void (*)(void* context, int member);
  void Run(Function function, void* context);
  void Work(const std::stop_token& stop, int member);

  int size_;
  std::mutex mutex_;  // of the five below
  std::condition_variable_any start_, done_;
  Function function_ = nullptr;
  void* context_ = nullptr;
  int64_t round_ = 0;
  int running_ = 0;
  std::vector<std::jthread> threads_;  // last: they end before what they use
};

/// Calls f(first, n, accumulate, work) for all chunks of a batch, after the feeder has been asked for their samples:
/// each member of the team takes adjacent ones in ascending order, with its own of `works`, and `accumulate` tells its
/// first from the others.
template <typename Work, typename F>
void ForChunks(UpdateTeam* team, const Chunks& chunks, BatchFeeder* feeder, std::vector<Work>* works, F f) {
  team->Run([&](int member) {
    const int begin = chunks.share_begin(member, team->size()), end = chunks.share_begin(member + 1, team->size());
    for (int c = begin; c < end; ++c) {
      const bool last = c + 1 == end;
      const int next = last ? begin : c + 1;
      feeder->Expect(chunks.first(next), chunks.size(next), last);
      feeder->Need(chunks.first(c), chunks.size(c));
      f(chunks.first(c), chunks.size(c), c == begin ? Accumulate::kOverwrite : Accumulate::kAdd, &(*works)[member]);
    }
  });
}

}  // namespace cairn::learner
