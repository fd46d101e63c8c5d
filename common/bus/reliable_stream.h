#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/bus/codec.h"
#include "common/core/clock.h"

namespace cairn {

/// What the receiving end says of a stream.
struct StreamPosition {
  int64_t received = 0;             ///< everything up to here was accepted
  int64_t durable = 0;              ///< and everything up to here is safe from the receiver's death
  int64_t window_bytes = 0;         ///< that may be on the way
  int64_t echo_us = 0;              ///< send_us of the newest message that came
  std::vector<SequenceRange> gaps;  ///< what is missing behind `received`
};

/// Sending end of an actor's reliable stream (DESIGN 9): a ring of encoded messages; cumulative acknowledgement that
/// frees the window, a durable one that frees the ring; what is reported missing is sent again once it has had the time
/// of a round trip; a probe when nothing is heard. Every message starts with the LCM fingerprint, utime and send_us,
/// which each (re)send stamps anew, so that its echo measures the round trip. One thread.
class ReliableSender {
 public:
  using Publish = std::function<void(const Bytes&)>;

  /// Keeps at most `max_kept_bytes` of messages that are received but not durable.
  explicit ReliableSender(Publish publish, int64_t max_kept_bytes = 64 << 20)
      : publish_(std::move(publish)), max_kept_bytes_(max_kept_bytes) {}

  /// Takes message `next_sequence()` and sends it as soon as the window allows.
  void Push(Bytes message, TimePoint now);

  /// Stale and foreign positions are ignored.
  void Acknowledge(const StreamPosition& position, TimePoint now);

  /// The receiver was restarted and has only what is up to `received`: the rest goes out again. False, and nothing
  /// changes, when the ring no longer has it.
  bool Rewind(int64_t received, TimePoint now);

  /// Sends what the window allows; sends the oldest unacknowledged message again when it has waited too long (smoothed
  /// round trip + 4 deviations, doubled per try, 100 ms … 1 s). Only after what came in was read: an owner that was
  /// busy for long may have its acknowledgement waiting.
  void Poll(TimePoint now);

  /// When Poll has to be called at the latest, if nothing comes in before.
  TimePoint next_probe() const;

  int64_t next_sequence() const { return base_ + static_cast<int64_t>(ring_.size()); }
  /// Newest sequence number pushed; 0 before the first.
  int64_t last_sequence() const { return next_sequence() - 1; }
  /// Everything is acknowledged.
  bool idle() const { return received_ == last_sequence(); }
  int64_t buffered_bytes() const { return buffered_bytes_; }
  int64_t sent() const { return sent_; }
  int64_t resent() const { return resent_; }
  int64_t round_trip_us() const { return static_cast<int64_t>(srtt_us_); }

 private:
  struct Entry {
    Bytes message;
    TimePoint sent_at{};
    bool sent = false;
  };
  Entry& entry(int64_t sequence) { return ring_[static_cast<size_t>(sequence - base_)]; }
  const Entry& entry(int64_t sequence) const { return ring_[static_cast<size_t>(sequence - base_)]; }
  void DropKept(int64_t durable);
  void SendAllowed(TimePoint now);
  void Send(Entry* entry, TimePoint now);
  void UpdateRoundTrip(int64_t echo_us);
  Duration RoundTrip(int tries, double least_us) const;

  Publish publish_;
  const int64_t max_kept_bytes_;
  std::deque<Entry> ring_;  // front has number base_; up to received_: kept; below next_: on the way; then unsent
  int64_t base_ = 1;
  int64_t received_ = 0;
  int64_t next_ = 1;  // to send
  int64_t buffered_bytes_ = 0;
  int64_t outstanding_bytes_ = 0;
  int64_t window_bytes_ = 60000;  // until the learner says
  int64_t last_echo_us_ = 0;
  double srtt_us_ = 2000;
  double rttvar_us_ = 2000;
  int tries_ = 0;
  int64_t sent_ = 0;
  int64_t resent_ = 0;
};

/// Receiving end: hands out 1, 2, 3 … exactly once and in order, keeps what comes early and knows what is missing.
template <typename Message>
class ReliableReceiver {
 public:
  enum class Verdict { kNew, kDuplicate, kTooEarly };

  /// Goes on after `received` messages.
  explicit ReliableReceiver(int64_t received = 0) : received_(received) {}

  Verdict Accept(int64_t sequence, Message message) {
    if (sequence <= received_ || early_.contains(sequence)) return Verdict::kDuplicate;
    if (early_.size() >= kMaxEarly && sequence != received_ + 1) return Verdict::kTooEarly;
    early_.emplace(sequence, std::move(message));
    return Verdict::kNew;
  }

  /// The next message in order, once.
  std::optional<Message> Take() {
    const auto first = early_.begin();
    if (first == early_.end() || first->first != received_ + 1) return std::nullopt;
    std::optional<Message> message(std::move(first->second));
    early_.erase(first);
    ++received_;
    return message;
  }

  /// Gives up what is missing before the oldest early message, so that Take goes on with that; how many. 0: nothing is
  /// early.
  int64_t SkipGap() {
    if (early_.empty()) return 0;
    const int64_t missing = early_.begin()->first - 1 - received_;
    received_ += missing;
    return missing;
  }

  size_t num_early() const { return early_.size(); }

  /// The sender has made messages up to this one.
  void Announce(int64_t sequence) { announced_ = sequence > announced_ ? sequence : announced_; }

  /// What is missing of what the sender is known to have made, oldest first, at most `max` ranges.
  std::vector<SequenceRange> Gaps(size_t max) const {
    std::vector<SequenceRange> gaps;
    int64_t expected = received_ + 1;
    for (const auto& [sequence, message] : early_) {
      if (gaps.size() == max) return gaps;
      if (sequence > expected) gaps.push_back({expected, sequence - 1});
      expected = sequence + 1;
    }
    if (announced_ >= expected && gaps.size() < max) gaps.push_back({expected, announced_});
    return gaps;
  }

  /// Cumulative position: everything up to here was taken.
  int64_t received() const { return received_; }

 private:
  static constexpr size_t kMaxEarly = 8192;  // far beyond what a window lets travel

  int64_t received_;
  int64_t announced_ = 0;
  std::map<int64_t, Message> early_;  // all behind received_
};

}  // namespace cairn
