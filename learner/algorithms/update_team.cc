#include "learner/algorithms/update_team.h"

#include "common/core/check.h"

namespace cairn::learner {

UpdateTeam::UpdateTeam(int size) : size_(size) {
  CAIRN_CHECK(size > 0);
  for (int member = 1; member < size; ++member) {
    threads_.emplace_back([this, member](const std::stop_token& stop) { Work(stop, member); });
  }
}

void UpdateTeam::Run(Function function, void* context) {
  if (size_ > 1) {
    const std::lock_guard lock(mutex_);
    function_ = function;
    context_ = context;
    running_ = size_ - 1;
    ++round_;
  }
  if (size_ > 1) start_.notify_all();
  function(context, 0);
  if (size_ == 1) return;
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return running_ == 0; });
}

void UpdateTeam::Work(const std::stop_token& stop, int member) {
  for (int64_t round = 1;; ++round) {
    std::unique_lock lock(mutex_);
    if (!start_.wait(lock, stop, [&] { return round_ >= round; })) return;
    const Function function = function_;
    void* const context = context_;
    lock.unlock();
    function(context, member);
    lock.lock();
    if (--running_ == 0) done_.notify_one();
  }
}

}  // namespace cairn::learner
