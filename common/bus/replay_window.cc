#include "common/bus/replay_window.h"

#include <algorithm>
#include <functional>

namespace cairn {

bool ReplayWindow::Accept(uint64_t counter) {
  if (highest_ >= kSize && counter <= highest_ - kSize) return false;
  const uint64_t word = counter / 64;
  if (counter > highest_) {
    const uint64_t newest = highest_ / 64;
    for (uint64_t i = 1; i <= std::min(word - newest, kWords); ++i) seen_[(newest + i) % kWords] = 0;
    highest_ = counter;
  }
  const uint64_t bit = uint64_t{1} << (counter % 64);
  uint64_t& bits = seen_[word % kWords];
  if ((bits & bit) != 0) return false;
  bits |= bit;
  return true;
}

size_t ReplayGuard::SenderHash::operator()(const Sender& s) const {
  return std::hash<int64_t>()(s.session ^ static_cast<int64_t>(s.plane));
}

bool ReplayGuard::Accept(Plane plane, int64_t session, uint64_t counter) {
  return Find({plane, session}).window.Accept(counter);
}

ReplayGuard::Entry& ReplayGuard::Find(const Sender& sender) {
  const auto known = senders_.find(sender);
  if (known != senders_.end()) {
    entries_.splice(entries_.begin(), entries_, known->second);
    return entries_.front();
  }
  if (senders_.size() >= capacity_) {
    senders_.erase(entries_.back().sender);
    entries_.pop_back();
  }
  entries_.push_front({sender, {}});
  senders_[sender] = entries_.begin();
  return entries_.front();
}

}  // namespace cairn
