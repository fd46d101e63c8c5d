#pragma once

#include <cstdint>
#include <deque>
#include <functional>

#include "common/bus/codec.h"
#include "common/core/clock.h"

namespace cairn {

/// Sending end of an actor's reliable stream (DESIGN 9), in its plain form: a ring of encoded messages, cumulative
/// acknowledgement, a byte window, go-back resend. Every message starts with the LCM fingerprint and an int64 utime,
/// which each (re)send stamps anew, so that its echo measures the round trip. One thread.
class ReliableSender {
 public:
  using Publish = std::function<void(const Bytes&)>;

  explicit ReliableSender(Publish publish) : publish_(std::move(publish)) {}

  /// Takes message `next_sequence()` and sends it as soon as the window allows.
  void Push(Bytes message, TimePoint now);

  /// What the learner's control frame says of this session. Stale and foreign positions are ignored.
  void Acknowledge(int64_t received, int64_t window_bytes, int64_t echo_utime, TimePoint now);

  /// Sends what the window allows; resends everything unacknowledged when the oldest has waited too long
  /// (smoothed round trip + 4 deviations, doubled per try, 20 ms … 1 s).
  void Poll(TimePoint now);

  int64_t next_sequence() const { return base_ + static_cast<int64_t>(ring_.size()); }
  /// Newest sequence number pushed; 0 before the first.
  int64_t last_sequence() const { return next_sequence() - 1; }
  bool idle() const { return ring_.empty(); }
  int64_t buffered_bytes() const { return buffered_bytes_; }
  int64_t sent() const { return sent_; }
  int64_t resent() const { return resent_; }

 private:
  struct Entry {
    Bytes message;
    TimePoint sent_at;
    bool sent = false;
  };
  void Send(Entry* entry, TimePoint now);
  void UpdateRoundTrip(int64_t echo_utime);
  Duration Timeout() const;

  Publish publish_;
  std::deque<Entry> ring_;  // unacknowledged and unsent, oldest first; front has number base_
  int64_t base_ = 1;
  size_t num_sent_ = 0;  // entries at the front of ring_ that are on the way
  int64_t buffered_bytes_ = 0;
  int64_t outstanding_bytes_ = 0;
  int64_t window_bytes_ = 60000;  // until the learner says
  int64_t last_echo_utime_ = 0;
  double srtt_us_ = 20000;
  double rttvar_us_ = 10000;
  int tries_ = 0;
  int64_t sent_ = 0;
  int64_t resent_ = 0;
};

/// Receiving end: accepts 1, 2, 3 … exactly once and in order.
class ReliableReceiver {
 public:
  enum class Verdict { kNew, kDuplicate, kGap };

  Verdict Accept(int64_t sequence) {
    if (sequence <= received_) return Verdict::kDuplicate;
    if (sequence > received_ + 1) return Verdict::kGap;
    received_ = sequence;
    return Verdict::kNew;
  }

  /// Cumulative position: everything up to here was accepted.
  int64_t received() const { return received_; }

 private:
  int64_t received_ = 0;
};

}  // namespace cairn
