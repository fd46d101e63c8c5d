#include "common/bus/reliable_stream.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"

namespace cairn {
namespace {

constexpr size_t kSendUsOffset = 16;  // behind fingerprint and utime
constexpr int kMaxBackOff = 5;
constexpr double kLeastHoldUs = 1e3;     // before what is missing is sent again
constexpr double kLeastTimeoutUs = 1e5;  // before a probe: a receiver on a busy machine may be away for some time

void StampSendUs(int64_t send_us, Bytes* message) {
  for (size_t i = 0; i < 8; ++i) {
    (*message)[kSendUsOffset + i] = static_cast<uint8_t>(static_cast<uint64_t>(send_us) >> (56 - 8 * i));
  }
}

int64_t Size(const Bytes& message) { return static_cast<int64_t>(message.size()); }

}  // namespace

void ReliableSender::Push(Bytes message, TimePoint now) {
  CAIRN_CHECK(message.size() >= kSendUsOffset + 8);
  buffered_bytes_ += Size(message);
  ring_.push_back({std::move(message)});
  SendAllowed(now);
}

void ReliableSender::Acknowledge(const StreamPosition& position, TimePoint now) {
  if (position.received >= next_) return;
  window_bytes_ = position.window_bytes;
  if (position.echo_us > last_echo_us_) UpdateRoundTrip(position.echo_us);
  for (; received_ < position.received; ++received_) {
    outstanding_bytes_ -= Size(entry(received_ + 1).message);
    tries_ = 0;
  }
  DropKept(position.durable);
  const Duration hold = RoundTrip(0, kLeastHoldUs);
  for (const SequenceRange& gap : position.gaps) {
    for (int64_t i = std::max(gap.first, received_ + 1); i <= gap.last && i < next_; ++i) {
      if (now - entry(i).sent_at > hold) Send(&entry(i), now);
    }
  }
  SendAllowed(now);
}

void ReliableSender::DropKept(int64_t durable) {
  while (base_ <= received_ && (base_ <= durable || buffered_bytes_ > max_kept_bytes_)) {
    buffered_bytes_ -= Size(ring_.front().message);
    ring_.pop_front();
    ++base_;
  }
}

bool ReliableSender::Rewind(int64_t received, TimePoint now) {
  if (received + 1 < base_ || received >= next_) return false;
  received_ = received;
  next_ = received + 1;
  outstanding_bytes_ = 0;
  tries_ = 0;
  DropKept(received);
  SendAllowed(now);
  return true;
}

void ReliableSender::Poll(TimePoint now) {
  if (now > next_probe()) {
    Send(&entry(received_ + 1), now);
    tries_ = std::min(tries_ + 1, kMaxBackOff);
  }
  SendAllowed(now);
}

void ReliableSender::SendAllowed(TimePoint now) {
  for (; next_ < next_sequence(); ++next_) {
    Entry& next = entry(next_);
    // One message may always travel, or a window smaller than a message would hang the stream.
    if (next_ > received_ + 1 && outstanding_bytes_ + Size(next.message) > window_bytes_) break;
    Send(&next, now);
    outstanding_bytes_ += Size(next.message);
  }
}

TimePoint ReliableSender::next_probe() const {
  if (received_ + 1 >= next_) return TimePoint::max();
  return entry(received_ + 1).sent_at + RoundTrip(tries_, kLeastTimeoutUs);
}

void ReliableSender::Send(Entry* entry, TimePoint now) {
  StampSendUs(MonotonicUs(), &entry->message);
  publish_(entry->message);
  ++(entry->sent ? resent_ : sent_);
  entry->sent = true;
  entry->sent_at = now;
}

// RFC 6298's estimator. The echo names the send it answers, so a resent message does not blur it.
void ReliableSender::UpdateRoundTrip(int64_t echo_us) {
  last_echo_us_ = echo_us;
  const auto rtt = static_cast<double>(std::clamp<int64_t>(MonotonicUs() - echo_us, 0, 1000000));
  rttvar_us_ += 0.25 * (std::abs(rtt - srtt_us_) - rttvar_us_);
  srtt_us_ += 0.125 * (rtt - srtt_us_);
}

Duration ReliableSender::RoundTrip(int tries, double least_us) const {
  const double us = std::clamp((srtt_us_ + 4 * rttvar_us_) * (1 << tries), least_us, 1e6);
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::micro>(us));
}

}  // namespace cairn
