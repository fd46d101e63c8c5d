#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/bus/lru_map.h"
#include "common/bus/plane.h"

namespace cairn {

/// Which counters of one sender were seen: the highest and, as bits, the kSize before it (as in RFC 6479). Frames that
/// overtake each other pass; a counter seen before, or too old to tell, does not.
class ReplayWindow {
 public:
  static constexpr uint64_t kSize = 1024;

  /// True the first time for each counter that is not `kSize` or more behind the highest so far.
  bool Accept(uint64_t counter);

 private:
  // One word more than the window has bits for: it moves by whole words.
  static constexpr uint64_t kWords = kSize / 64 + 1;

  uint64_t highest_ = 0;
  std::array<uint64_t, kWords> seen_{};
};

/// A window for each (plane, session) heard of late. Ask only about frames whose tag was right: others could push true
/// sessions out. Not thread-safe.
class ReplayGuard {
 public:
  /// Sessions remembered; a longer-silent one is forgotten first. 4096 are 0.8 MB.
  explicit ReplayGuard(size_t capacity = 4096) : senders_(capacity) {}

  /// False when the frame was accepted before or is too old to tell.
  bool Accept(Plane plane, int64_t session, uint64_t counter);

  size_t size() const { return senders_.size(); }

 private:
  struct Sender {
    Plane plane = Plane::kExperience;
    int64_t session = 0;
    bool operator==(const Sender&) const = default;
  };
  struct SenderHash {
    size_t operator()(const Sender& s) const;
  };

  LruMap<Sender, ReplayWindow, SenderHash> senders_;
};

}  // namespace cairn
