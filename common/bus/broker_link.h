#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/bus/broker_connection.h"
#include "common/core/bytes.h"
#include "common/core/clock.h"

namespace lcm {
struct ReceiveBuffer;
}

namespace cairn {

/// Why no messages travel, and since when.
struct Outage {
  std::string broker;  ///< "HOST:PORT"
  std::string reason;
  TimePoint since;
};

/// One plane over an LCM broker: a connection and a thread for each direction, with bounded queues between them and the
/// process. Nothing here waits for the broker but those threads; they come back by themselves when it does. The
/// receiving one always reads, so that this process never is the slow subscriber who stalls all others. What a queue
/// cannot hold, and what is published while there is no broker, is dropped and counted, as a network would. LCM's
/// publish corrupts a tcpq stream when two threads call it: here one thread does. All functions from any thread.
class BrokerLink {
 public:
  struct Datagram {
    std::string channel;
    Bytes bytes;
  };

  /// `broker` is "HOST:PORT". `wake_fd` is an eventfd that is written when the state changes.
  BrokerLink(std::string broker, int wake_fd);
  ~BrokerLink();
  BrokerLink(const BrokerLink&) = delete;
  BrokerLink& operator=(const BrokerLink&) = delete;

  void Publish(const std::string& channel, Bytes bytes);

  /// `channels` is an LCM regular expression; the broker sends what fits it.
  void Subscribe(const std::string& channels);

  /// The oldest datagram that has come in. fd() is readable while there may be one.
  std::optional<Datagram> Take();
  int fd() const { return received_fd_; }

  /// Empty while messages travel in all directions that are used.
  std::optional<Outage> outage() const;

  /// Messages that no queue could hold, or for which there was no broker.
  int64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

  /// Bytes that may wait to be taken.
  static constexpr int kQueueBytes = 8 << 20;

 private:
  // What is known of one direction, for outage().
  struct Direction {
    bool used = false;
    std::string fault = "not connected yet";  // empty: connected
    TimePoint since = Clock::now();
  };
  void Send(const std::stop_token& stop);
  void Receive(const std::stop_token& stop);
  bool Reopen(BrokerConnection* connection, Direction* direction);
  void Lose(BrokerConnection* connection, Direction* direction, const std::string& fault);
  bool SendBatch(BrokerConnection* connection, const std::deque<Datagram>& batch, const std::stop_token& stop);
  bool WaitWritable(int fd, const std::stop_token& stop);
  void SubscribeNew(BrokerConnection* connection, size_t* subscribed);
  void OnDatagram(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void Push(const std::string& channel, const void* data, size_t size);

  const std::string broker_;
  const int wake_fd_;
  const int received_fd_;  // eventfd: something may be taken
  const int send_fd_;      // eventfd: something to send, or stop
  const int receive_fd_;   // eventfd: a new subscription, or stop

  mutable std::mutex mutex_;  // guards everything down to the threads
  Direction sending_, receiving_;
  std::deque<Datagram> to_send_;
  int64_t to_send_bytes_ = 0;
  std::optional<TimePoint> stuck_since_;  // the broker takes nothing
  std::deque<Datagram> received_;
  int64_t received_bytes_ = 0;
  std::vector<std::string> channels_;

  bool pushed_ = false;  // of the receiving thread: the datagram that LCM hands out
  std::atomic<int64_t> dropped_{0};
  std::jthread sender_, receiver_;
};

}  // namespace cairn
