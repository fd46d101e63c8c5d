#include "common/bus/broker_link.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <lcm/lcm-cpp.hpp>
#include <utility>

#include "common/core/check.h"

namespace cairn {
namespace {

constexpr int kRetryMs = 200;
constexpr size_t kQueueMessages = 20000;
constexpr auto kStuckIsOutage = std::chrono::seconds(1);

int MakeEvent() {
  const int fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  CAIRN_CHECK(fd >= 0);
  return fd;
}

void Drain(int fd) {
  eventfd_t ignored = 0;
  eventfd_read(fd, &ignored);
}

void SetTcp(int fd, int option, int value) { setsockopt(fd, IPPROTO_TCP, option, &value, sizeof value); }

// Events of a socket, of `event_fd` or of neither within `ms`.
struct Events {
  bool event = false;
  short socket = 0;
};
Events Wait(int event_fd, int socket_fd, short socket_events, int ms) {
  std::array<pollfd, 2> fds{{{event_fd, POLLIN, 0}, {socket_fd, socket_events, 0}}};
  if (poll(fds.data(), socket_fd >= 0 ? 2 : 1, ms) <= 0) return {};
  return {(fds[0].revents & POLLIN) != 0, fds[1].revents};
}

constexpr short kGone = POLLRDHUP | POLLHUP | POLLERR;

}  // namespace

BrokerLink::BrokerLink(std::string broker, int wake_fd)
    : broker_(std::move(broker)),
      wake_fd_(wake_fd),
      received_fd_(MakeEvent()),
      send_fd_(MakeEvent()),
      receive_fd_(MakeEvent()) {}

BrokerLink::~BrokerLink() {
  sender_.request_stop();
  receiver_.request_stop();
  eventfd_write(send_fd_, 1);
  eventfd_write(receive_fd_, 1);
  if (sender_.joinable()) sender_.join();
  if (receiver_.joinable()) receiver_.join();
  for (const int fd : {received_fd_, send_fd_, receive_fd_}) close(fd);
}

// --- the process's side ----------------------------------------------------------------------------------------------

void BrokerLink::Publish(const std::string& channel, Bytes bytes) {
  const std::lock_guard lock(mutex_);
  if (!sending_.used) {
    sending_.used = true;
    sending_.since = Clock::now();
    sender_ = std::jthread([this](const std::stop_token& stop) { Send(stop); });
  }
  const auto size = static_cast<int64_t>(bytes.size());
  if (to_send_.size() >= kQueueMessages || to_send_bytes_ + size > kQueueBytes) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  to_send_bytes_ += size;
  to_send_.push_back({channel, std::move(bytes)});
  if (to_send_.size() == 1) eventfd_write(send_fd_, 1);
}

void BrokerLink::Subscribe(const std::string& channels) {
  const std::lock_guard lock(mutex_);
  channels_.push_back(channels);
  if (!receiving_.used) {
    receiving_.used = true;
    receiving_.since = Clock::now();
    receiver_ = std::jthread([this](const std::stop_token& stop) { Receive(stop); });
  }
  eventfd_write(receive_fd_, 1);
}

std::optional<BrokerLink::Datagram> BrokerLink::Take() {
  const std::lock_guard lock(mutex_);
  if (received_.empty()) {
    Drain(received_fd_);
    return std::nullopt;
  }
  std::optional<Datagram> oldest(std::move(received_.front()));
  received_.pop_front();
  received_bytes_ -= static_cast<int64_t>(oldest->bytes.size());
  return oldest;
}

std::optional<Outage> BrokerLink::outage() const {
  const std::lock_guard lock(mutex_);
  for (const Direction* direction : {&sending_, &receiving_}) {
    if (direction->used && !direction->fault.empty()) return Outage{broker_, direction->fault, direction->since};
  }
  if (stuck_since_ && Clock::now() - *stuck_since_ > kStuckIsOutage) {
    return Outage{broker_, "it takes no messages; has one of its subscribers stopped?", *stuck_since_};
  }
  return std::nullopt;
}

// --- both threads ----------------------------------------------------------------------------------------------------

bool BrokerLink::Reopen(BrokerConnection* connection, Direction* direction) {
  const std::string fault = connection->Open();
  {
    const std::lock_guard lock(mutex_);
    direction->fault = fault;
  }
  if (fault.empty()) eventfd_write(wake_fd_, 1);
  return fault.empty();
}

void BrokerLink::Lose(BrokerConnection* connection, Direction* direction, const std::string& fault) {
  connection->Close();
  {
    const std::lock_guard lock(mutex_);
    direction->fault = fault;
    direction->since = Clock::now();
  }
  eventfd_write(wake_fd_, 1);
}

// --- sending ---------------------------------------------------------------------------------------------------------

void BrokerLink::Send(const std::stop_token& stop) {
  BrokerConnection connection(broker_);
  while (!stop.stop_requested()) {
    if (!connection.is_open()) {
      if (Reopen(&connection, &sending_)) {
        const int bytes = 400000;  // more than a message when it is said to be writable, so that LCM never waits
        setsockopt(connection.fd(), SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
        continue;
      }
      {
        // What waited is old when the broker is back, and everything is said again.
        const std::lock_guard lock(mutex_);
        dropped_.fetch_add(static_cast<int64_t>(to_send_.size()), std::memory_order_relaxed);
        to_send_.clear();
        to_send_bytes_ = 0;
      }
      // Publish rings too; only the end ends the pause early.
      for (int i = 0; i < kRetryMs / 20 && !stop.stop_requested(); ++i) Wait(-1, -1, 0, 20);
      continue;
    }
    const Events events = Wait(send_fd_, connection.fd(), POLLRDHUP, -1);
    if ((events.socket & kGone) != 0) {
      Lose(&connection, &sending_, "it closed the connection");
      continue;
    }
    if (!events.event) continue;
    Drain(send_fd_);
    std::deque<Datagram> batch;
    {
      const std::lock_guard lock(mutex_);
      batch.swap(to_send_);
      to_send_bytes_ = 0;
    }
    if (!SendBatch(&connection, batch, stop)) Lose(&connection, &sending_, "the connection broke");
  }
}

// LCM writes each message in five pieces: they leave together. False: the connection is of no use any more.
bool BrokerLink::SendBatch(BrokerConnection* connection, const std::deque<Datagram>& batch,
                           const std::stop_token& stop) {
  const int fd = connection->fd();
  SetTcp(fd, TCP_CORK, 1);
  for (size_t i = 0; i < batch.size(); ++i) {
    const Bytes& bytes = batch[i].bytes;
    const bool sent = WaitWritable(fd, stop) && connection->lcm().publish(batch[i].channel, bytes.data(),
                                                                          static_cast<unsigned>(bytes.size())) == 0;
    if (sent) continue;
    dropped_.fetch_add(static_cast<int64_t>(batch.size() - i), std::memory_order_relaxed);
    return false;
  }
  SetTcp(fd, TCP_CORK, 0);
  return true;
}

// A broker that waits for a slow subscriber takes nothing meanwhile; that is waited for here, not inside LCM.
bool BrokerLink::WaitWritable(int fd, const std::stop_token& stop) {
  const auto set_stuck = [this](std::optional<TimePoint> since) {
    const std::lock_guard lock(mutex_);
    stuck_since_ = since;
  };
  for (int tries = 0; !stop.stop_requested(); ++tries) {
    const short events = Wait(-1, fd, POLLOUT | POLLRDHUP, tries == 0 ? 0 : 20).socket;
    if ((events & kGone) != 0) break;
    if ((events & POLLOUT) != 0) {
      if (tries > 0) set_stuck(std::nullopt);
      return true;
    }
    if (tries == 0) set_stuck(Clock::now());
  }
  set_stuck(std::nullopt);
  return false;
}

// --- receiving -------------------------------------------------------------------------------------------------------

void BrokerLink::Receive(const std::stop_token& stop) {
  BrokerConnection connection(broker_);
  size_t subscribed = 0;
  while (!stop.stop_requested()) {
    if (!connection.is_open()) {
      subscribed = 0;
      if (!Reopen(&connection, &receiving_)) Wait(receive_fd_, -1, 0, kRetryMs);
      if (connection.is_open()) SubscribeNew(&connection, &subscribed);
      continue;
    }
    const Events events = Wait(receive_fd_, connection.fd(), POLLIN | POLLRDHUP, -1);
    if (events.event) {
      Drain(receive_fd_);
      SubscribeNew(&connection, &subscribed);
    }
    if ((events.socket & POLLIN) != 0) {
      // The broker writes in pieces too, and waits for our acknowledgement of the first, which would wait 40 ms.
      SetTcp(connection.fd(), TCP_QUICKACK, 1);
      pushed_ = false;
      if (connection.lcm().handle() != 0) Lose(&connection, &receiving_, "it closed the connection");
    } else if ((events.socket & kGone) != 0) {
      Lose(&connection, &receiving_, "it closed the connection");
    }
  }
}

void BrokerLink::SubscribeNew(BrokerConnection* connection, size_t* subscribed) {
  std::vector<std::string> wanted;
  {
    const std::lock_guard lock(mutex_);
    wanted.assign(channels_.begin() + static_cast<std::ptrdiff_t>(*subscribed), channels_.end());
    *subscribed = channels_.size();
  }
  for (const std::string& channels : wanted) connection->lcm().subscribe(channels, &BrokerLink::OnDatagram, this);
}

// LCM calls it once for each subscription that a datagram fits; one is enough.
void BrokerLink::OnDatagram(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
  if (!std::exchange(pushed_, true)) Push(channel, buffer->data, buffer->data_size);
}

void BrokerLink::Push(const std::string& channel, const void* data, size_t size) {
  const std::lock_guard lock(mutex_);
  if (received_.size() >= kQueueMessages || received_bytes_ + static_cast<int64_t>(size) > kQueueBytes) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  const auto* bytes = static_cast<const uint8_t*>(data);
  received_.push_back({channel, Bytes(bytes, bytes + size)});
  received_bytes_ += static_cast<int64_t>(size);
  if (received_.size() == 1) eventfd_write(received_fd_, 1);
}

}  // namespace cairn
