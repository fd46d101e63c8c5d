#include "learner/algorithms/update_team.h"

#include "common/core/check.h"

namespace cairn::learner {

UpdateTeam::UpdateTeam(int size) : size_(size), next_share_(size) {
  CAIRN_CHECK(size > 0);
  for (int i = 1; i < size; ++i) {
    threads_.emplace_back([this](const std::stop_token& stop) { Help(stop); });
  }
}

void UpdateTeam::Run(Function function, void* context) {
  if (size_ == 1) return function(context, 0);
  std::unique_lock lock(mutex_);
  function_ = function;
  context_ = context;
  next_share_ = 0;
  unfinished_ = size_;
  start_.notify_all();
  TakeShares(&lock);
  done_.wait(lock, [this] { return unfinished_ == 0; });
}

void UpdateTeam::Help(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (start_.wait(lock, stop, [this] { return next_share_ < size_; })) TakeShares(&lock);
}

// The lock is held before and after, not while a share runs.
void UpdateTeam::TakeShares(std::unique_lock<std::mutex>* lock) {
  while (next_share_ < size_) {
    const int share = next_share_++;
    const Function function = function_;
    void* const context = context_;
    lock->unlock();
    function(context, share);
    lock->lock();
    if (--unfinished_ == 0) done_.notify_one();
  }
}

}  // namespace cairn::learner
