#include "learner/replay/replay_buffer.h"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "common/core/check.h"

namespace cairn::learner {
namespace {

constexpr int kFloatsPerCacheLine = 16;

int RoundUpToCacheLine(int floats) {
  return (floats + kFloatsPerCacheLine - 1) / kFloatsPerCacheLine * kFloatsPerCacheLine;
}

// Pages of an anonymous mapping cost nothing until they are written. Huge pages spare the random gather most of its
// TLB misses; the advice may be refused without harm.
float* MapRows(size_t bytes, int capacity, int row_floats) {
  void* p = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (p == MAP_FAILED) {
    ThrowError("learner.buffer_size {}: {} rows of {} bytes cannot be reserved: {}", capacity, capacity,
               row_floats * sizeof(float), std::strerror(errno));
  }
  ::madvise(p, bytes, MADV_HUGEPAGE);
  return static_cast<float*>(p);
}

}  // namespace

void ReplayBuffer::Unmap::operator()(float* p) const { ::munmap(p, bytes); }

ReplayBuffer::ReplayBuffer(int capacity, int observation_size, int action_size, int n_steps, double gamma)
    : capacity_(capacity),
      observation_size_(observation_size),
      action_size_(action_size),
      n_steps_(n_steps),
      row_floats_(RoundUpToCacheLine(2 * observation_size + action_size + 2)) {
  CAIRN_CHECK(capacity > 0 && observation_size > 0 && action_size > 0 && n_steps > 0);
  gamma_powers_.push_back(1.0);
  for (int m = 1; m <= n_steps; ++m) gamma_powers_.push_back(gamma_powers_.back() * gamma);
  const size_t bytes = static_cast<size_t>(capacity) * row_floats_ * sizeof(float);
  rows_ = {MapRows(bytes, capacity, row_floats_), Unmap{bytes}};
}

int ReplayBuffer::Insert(const Segment& segment) {
  const int steps = segment.num_steps();
  CAIRN_CHECK(segment.observations.size() == static_cast<size_t>(steps + 1) * observation_size_ &&
                  segment.actions.size() == static_cast<size_t>(steps) * action_size_,
              "segment of {} steps: {} observation and {} action floats", steps, segment.observations.size(),
              segment.actions.size());
  for (int t = 0; t < steps; ++t) FillRow(segment, t, NextRow());
  return steps;
}

// The slot of the next row, which takes the place of the oldest when the buffer is full.
float* ReplayBuffer::NextRow() {
  for (int64_t from; (from = protected_from_.load(std::memory_order_acquire)) <= num_inserted_ - capacity_;) {
    protected_from_.wait(from);
  }
  float* row = rows_.get() + static_cast<size_t>(num_inserted_ % capacity_) * row_floats_;
  ++num_inserted_;
  size_ = std::min(size_ + 1, capacity_);
  return row;
}

void ReplayBuffer::StartAt(int64_t n) {
  CAIRN_CHECK(size_ == 0 && n >= 0);
  num_inserted_ = n;
}

void ReplayBuffer::AppendRow(const float* row) { std::copy_n(row, row_floats_, NextRow()); }

// R = Σ γ^i r_{t+i} over i < m, bootstrapped by γ^m from the observation m steps on.
void ReplayBuffer::FillRow(const Segment& segment, int step, float* row) const {
  const int m = std::min(n_steps_, segment.num_steps() - step);
  const bool reaches_end = step + m == segment.num_steps();
  const bool bootstrap = !(reaches_end && segment.end == SegmentEnd::kTerminated);
  double n_step_return = 0;
  for (int i = 0; i < m; ++i) n_step_return += gamma_powers_[i] * segment.rewards[step + i];

  const float* observation = segment.observations.data() + static_cast<size_t>(step) * observation_size_;
  const float* action = segment.actions.data() + static_cast<size_t>(step) * action_size_;
  std::copy_n(observation, observation_size_, row);
  std::copy_n(action, action_size_, row + action_offset());
  row[reward_offset()] = static_cast<float>(n_step_return);
  row[discount_offset()] = bootstrap ? static_cast<float>(gamma_powers_[m]) : 0.0f;
  std::copy_n(observation + static_cast<size_t>(m) * observation_size_, observation_size_,
              row + next_observation_offset());
}

}  // namespace cairn::learner
