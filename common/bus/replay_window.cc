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
  const Sender sender{plane, session};
  ReplayWindow* window = senders_.Find(sender);
  if (window == nullptr) window = senders_.Insert(sender, {});
  return window->Accept(counter);
}

}  // namespace cairn
