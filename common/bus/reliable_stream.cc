#include "common/bus/reliable_stream.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"

namespace cairn {
namespace {

constexpr size_t kUtimeOffset = 8;  // behind the fingerprint
constexpr int kMaxBackOff = 5;

void StampUtime(int64_t utime, Bytes* message) {
  for (size_t i = 0; i < 8; ++i) {
    (*message)[kUtimeOffset + i] = static_cast<uint8_t>(static_cast<uint64_t>(utime) >> (56 - 8 * i));
  }
}

}  // namespace

void ReliableSender::Push(Bytes message, TimePoint now) {
  CAIRN_CHECK(message.size() >= kUtimeOffset + 8);
  buffered_bytes_ += static_cast<int64_t>(message.size());
  ring_.push_back({std::move(message), now});
  Poll(now);
}

void ReliableSender::Acknowledge(int64_t received, int64_t window_bytes, int64_t echo_utime, TimePoint now) {
  if (received > last_sequence()) return;
  window_bytes_ = window_bytes;
  if (echo_utime > last_echo_utime_) UpdateRoundTrip(echo_utime);
  for (; base_ <= received; ++base_) {
    const auto bytes = static_cast<int64_t>(ring_.front().message.size());
    buffered_bytes_ -= bytes;
    outstanding_bytes_ -= bytes;
    ring_.pop_front();
    --num_sent_;
    tries_ = 0;
  }
  Poll(now);
}

void ReliableSender::Poll(TimePoint now) {
  if (num_sent_ > 0 && now - ring_.front().sent_at > Timeout()) {
    for (size_t i = 0; i < num_sent_; ++i) Send(&ring_[i], now);
    tries_ = std::min(tries_ + 1, kMaxBackOff);
  }
  while (num_sent_ < ring_.size()) {
    Entry& entry = ring_[num_sent_];
    const auto bytes = static_cast<int64_t>(entry.message.size());
    // One message may always travel, or a window smaller than a message would hang the stream.
    if (num_sent_ > 0 && outstanding_bytes_ + bytes > window_bytes_) break;
    Send(&entry, now);
    outstanding_bytes_ += bytes;
    ++num_sent_;
  }
}

void ReliableSender::Send(Entry* entry, TimePoint now) {
  StampUtime(WallUs(), &entry->message);
  publish_(entry->message);
  ++(entry->sent ? resent_ : sent_);
  entry->sent = true;
  entry->sent_at = now;
}

// RFC 6298's estimator. The echo names the send it answers, so a resent message does not blur it.
void ReliableSender::UpdateRoundTrip(int64_t echo_utime) {
  last_echo_utime_ = echo_utime;
  const auto rtt = static_cast<double>(std::clamp<int64_t>(WallUs() - echo_utime, 0, 1000000));
  rttvar_us_ += 0.25 * (std::abs(rtt - srtt_us_) - rttvar_us_);
  srtt_us_ += 0.125 * (rtt - srtt_us_);
}

Duration ReliableSender::Timeout() const {
  const double us = std::clamp((srtt_us_ + 4 * rttvar_us_) * (1 << tries_), 20e3, 1e6);
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::micro>(us));
}

}  // namespace cairn
