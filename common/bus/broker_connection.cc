#include "common/bus/broker_connection.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/core.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <lcm/lcm-cpp.hpp>
#include <mutex>
#include <utility>
#include <vector>

#include "common/core/clock.h"

namespace cairn {
namespace {

constexpr auto kProbeTime = std::chrono::seconds(2);
constexpr std::array<uint8_t, 4> kServerMagic{0x28, 0x76, 0x17, 0xfa};  // what a broker says first; its version follows
constexpr int kGreetingBytes = 8;

// A socket that closes.
class Socket {
 public:
  explicit Socket(int fd) : fd_(fd) {}
  ~Socket() {
    if (fd_ >= 0) close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

bool WaitFor(int fd, short events, TimePoint deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
  pollfd event{fd, events, 0};
  return left > 0 && poll(&event, 1, static_cast<int>(left)) > 0;
}

struct Address {
  sockaddr_in name{};
  std::string fault;
};

// IPv4, all that LCM's client knows.
Address Resolve(const std::string& broker) {
  const size_t colon = broker.find(':');
  const std::string host = broker.substr(0, colon);
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  Address address;
  if (const int error = getaddrinfo(host.c_str(), broker.substr(colon + 1).c_str(), &hints, &found); error != 0) {
    address.fault = fmt::format("cannot find host '{}': {}", host, gai_strerror(error));
    return address;
  }
  std::memcpy(&address.name, found->ai_addr, sizeof address.name);
  freeaddrinfo(found);
  return address;
}

// Empty when connected.
std::string Connect(int fd, const sockaddr_in& name, TimePoint deadline) {
  if (connect(fd, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0) return "";
  if (errno != EINPROGRESS) return std::strerror(errno);
  if (!WaitFor(fd, POLLOUT, deadline)) return "no answer within 2 s";
  int error = 0;
  socklen_t length = sizeof error;
  getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &length);
  return error == 0 ? "" : std::strerror(error);
}

std::string ReadGreeting(int fd, TimePoint deadline) {
  std::array<uint8_t, kGreetingBytes> greeting{};
  size_t got = 0;
  while (got < greeting.size()) {
    if (!WaitFor(fd, POLLIN, deadline)) return "it took the connection and then said nothing for 2 s";
    const ssize_t n = recv(fd, greeting.data() + got, greeting.size() - got, 0);
    if (n < 0 && errno == EAGAIN) continue;
    if (n <= 0) return "it closed the connection at once";
    got += static_cast<size_t>(n);
  }
  if (std::memcmp(greeting.data(), kServerMagic.data(), kServerMagic.size()) != 0) return "it is no LCM broker";
  return "";
}

std::string Probe(const sockaddr_in& name) {
  const TimePoint deadline = Clock::now() + kProbeTime;
  const Socket probe(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (probe.fd() < 0) return std::strerror(errno);
  std::string fault = Connect(probe.fd(), name, deadline);
  return fault.empty() ? ReadGreeting(probe.fd(), deadline) : fault;
}

template <typename T>
void Set(int fd, int level, int option, T value) {
  setsockopt(fd, level, option, &value, sizeof value);
}

// LCM waits for the rest of a message inside its calls: a broker that stops in the middle must not hold a thread for
// good, and a host that vanished must be noticed without traffic.
void BoundWaits(int fd) {
  const timeval most{5, 0};
  Set(fd, SOL_SOCKET, SO_RCVTIMEO, most);
  Set(fd, SOL_SOCKET, SO_SNDTIMEO, most);
  Set(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
  Set(fd, IPPROTO_TCP, TCP_KEEPIDLE, 5);
  Set(fd, IPPROTO_TCP, TCP_KEEPINTVL, 2);
  Set(fd, IPPROTO_TCP, TCP_KEEPCNT, 3);
  fcntl(fd, F_SETFD, FD_CLOEXEC);
}

}  // namespace

std::string ProbeBroker(const std::string& broker) {
  const Address address = Resolve(broker);
  return address.fault.empty() ? Probe(address.name) : address.fault;
}

std::string BrokerCommand(const std::string& broker) {
  return fmt::format("java -cp /usr/share/java/lcm.jar lcm.lcm.TCPService {}", broker.substr(broker.find(':') + 1));
}

BrokerConnection::BrokerConnection(std::string broker) : broker_(std::move(broker)) {}
BrokerConnection::~BrokerConnection() = default;

int BrokerConnection::fd() const { return lcm_ ? lcm_->getFileno() : -1; }

// To destroy an object whose socket failed is to let LCM connect again, once for each subscription and without limit of
// time. So it is put aside for good instead: some kilobytes each time a broker goes away.
void BrokerConnection::Close() {
  static std::mutex mutex;
  static auto& put_aside = *new std::vector<std::unique_ptr<lcm::LCM>>;
  if (!lcm_) return;
  if (fd() >= 0) close(fd());
  const std::lock_guard lock(mutex);
  put_aside.push_back(std::move(lcm_));
}

std::string BrokerConnection::Open() {
  const Address address = Resolve(broker_);
  if (!address.fault.empty()) return address.fault;
  if (std::string fault = Probe(address.name); !fault.empty()) return fault;
  std::array<char, INET_ADDRSTRLEN> host{};
  inet_ntop(AF_INET, &address.name.sin_addr, host.data(), host.size());
  lcm_ = std::make_unique<lcm::LCM>(fmt::format("tcpq://{}:{}", host.data(), ntohs(address.name.sin_port)));
  if (!lcm_->good() || lcm_->getFileno() < 0) {
    lcm_.reset();
    return "it went away while LCM connected";
  }
  BoundWaits(fd());
  return "";
}

}  // namespace cairn
