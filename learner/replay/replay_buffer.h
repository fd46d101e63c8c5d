#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/rl/segment.h"

namespace cairn::learner {

/// Ring of n-step transitions. One 64-byte-aligned row holds observation, action, n-step return, discount of the
/// bootstrap (γ^m, 0 after a terminated end) and next observation, so that sampling is one aligned gather.
/// One thread.
class ReplayBuffer {
 public:
  /// Memory is reserved at once: capacity × row_floats() × 4 bytes, touched as it fills. Throws Error when the system
  /// refuses it.
  ReplayBuffer(int capacity, int observation_size, int action_size, int n_steps, double gamma);

  /// Adds one row per step of the segment: return of the next m = min(n_steps, steps left in the segment) rewards and
  /// the observation m steps on. Bootstrap: terminated → none within reach of the end; otherwise γ^m (DESIGN 25).
  /// Overwrites the oldest rows when full. Returns the number of rows added (= segment.num_steps()).
  int Insert(const Segment& segment);

  int size() const { return size_; }
  int capacity() const { return capacity_; }
  int64_t num_inserted() const { return num_inserted_; }

  int row_floats() const { return row_floats_; }
  int observation_size() const { return observation_size_; }
  int action_size() const { return action_size_; }
  /// Row i < size(): observation at 0, action at action_offset(), reward, discount, next observation.
  const float* row(int i) const { return rows_.get() + static_cast<size_t>(i) * row_floats_; }
  /// The n-th row since the run's start; one of the last size().
  const float* RowOf(int64_t n) const { return rows_.get() + static_cast<size_t>(n % capacity_) * row_floats_; }

  /// Another thread reads rows from the n-th on until Unprotect: Insert waits rather than overwrite one of them (which
  /// takes a whole buffer of new rows). Call Protect on the inserting thread, Unprotect on any.
  void Protect(int64_t n) { protected_from_.store(n, std::memory_order_relaxed); }
  void Unprotect() {
    protected_from_.store(kNothingProtected, std::memory_order_release);
    protected_from_.notify_all();
  }

  /// Forgets every row.
  void Clear() { size_ = 0, num_inserted_ = 0; }

  /// For an empty buffer: its next row is the n-th since the run's start.
  void StartAt(int64_t n);

  /// Appends a finished row of row_floats(), as RowOf gave it.
  void AppendRow(const float* row);

  /// Asks for row i to be brought into the first-level cache. (On Zen 5 the hint for the second level leaves it in the
  /// third: a gather of 1024 rows then takes 30 µs instead of 10.)
  void Prefetch(int i) const {
    const float* p = row(i);
    for (int f = 0; f < row_floats_; f += 16) __builtin_prefetch(p + f);
  }
  int action_offset() const { return observation_size_; }
  int reward_offset() const { return observation_size_ + action_size_; }
  int discount_offset() const { return observation_size_ + action_size_ + 1; }
  int next_observation_offset() const { return observation_size_ + action_size_ + 2; }

 private:
  static constexpr int64_t kNothingProtected = INT64_MAX;
  struct Unmap {
    size_t bytes = 0;
    void operator()(float* p) const;
  };
  void FillRow(const Segment& segment, int step, float* row) const;
  float* NextRow();

  int capacity_, observation_size_, action_size_, n_steps_, row_floats_;
  int size_ = 0;
  std::atomic<int64_t> protected_from_{kNothingProtected};
  int64_t num_inserted_ = 0;
  std::vector<double> gamma_powers_;  // γ^0 … γ^n_steps
  std::unique_ptr<float[], Unmap> rows_{nullptr, Unmap{}};
};

}  // namespace cairn::learner
