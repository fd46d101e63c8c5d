#include "deploy/doctor/multicast_socket.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "common/bus/receive_buffer.h"

namespace cairn::deploy {
namespace {

constexpr std::string_view kMagic = "LC02";
constexpr size_t kSequenceBytes = 4;
constexpr std::string_view kChannel{"CAIRN_DOCTOR\0", 13};
constexpr size_t kHeaderBytes = kMagic.size() + kSequenceBytes + kChannel.size();

sockaddr_in Name(const std::string& address, int port) {
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(static_cast<uint16_t>(port));
  inet_pton(AF_INET, address.c_str(), &name.sin_addr);
  return name;
}

bool IsOurs(const uint8_t* bytes, size_t size) {
  return size >= kHeaderBytes && std::memcmp(bytes, kMagic.data(), kMagic.size()) == 0 &&
         std::memcmp(bytes + kMagic.size() + kSequenceBytes, kChannel.data(), kChannel.size()) == 0;
}

template <typename T>
bool Set(int fd, int level, int option, const T& value) {
  return setsockopt(fd, level, option, &value, sizeof(value)) == 0;
}

}  // namespace

MulticastSocket::MulticastSocket(const std::string& group, int port, int ttl)
    : group_(group), port_(port), fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  if (fd_ < 0) {
    Fail("make a UDP socket");
    return;
  }
  Set(fd_, SOL_SOCKET, SO_REUSEADDR, 1);
  Set(fd_, SOL_SOCKET, SO_RCVBUF, kWantedReceiveBuffer);
  Set(fd_, SOL_SOCKET, SO_RXQ_OVFL, 1);
  Set(fd_, IPPROTO_IP, IP_MULTICAST_TTL, ttl);
  const sockaddr_in name = Name("0.0.0.0", port);
  if (bind(fd_, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) != 0) {
    Fail("bind");
    return;
  }
  ip_mreq membership{};
  membership.imr_multiaddr = Name(group, port).sin_addr;
  if (!Set(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, membership)) Fail("join the group");
}

MulticastSocket::MulticastSocket(MulticastSocket&& other) noexcept
    : group_(std::move(other.group_)),
      port_(other.port_),
      fd_(std::exchange(other.fd_, -1)),
      failed_step_(std::move(other.failed_step_)),
      error_(other.error_),
      dropped_(other.dropped_),
      sequence_(other.sequence_),
      senders_(std::move(other.senders_)) {}

MulticastSocket::~MulticastSocket() {
  if (fd_ >= 0) close(fd_);
}

void MulticastSocket::Fail(const char* step) {
  error_ = errno;
  failed_step_ = step;
}

int MulticastSocket::Send(const Bytes& payload) { return SendTo(group_, payload); }

int MulticastSocket::SendTo(const std::string& address, const Bytes& payload) {
  Bytes datagram(kHeaderBytes + payload.size());
  const uint32_t sequence = htonl(sequence_++);
  std::copy(kMagic.begin(), kMagic.end(), datagram.begin());
  std::memcpy(datagram.data() + kMagic.size(), &sequence, kSequenceBytes);
  std::copy(kChannel.begin(), kChannel.end(), datagram.begin() + kMagic.size() + kSequenceBytes);
  std::copy(payload.begin(), payload.end(), datagram.begin() + kHeaderBytes);
  const sockaddr_in to = Name(address, port_);
  const ssize_t sent =
      sendto(fd_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof(to));
  return sent < 0 ? errno : 0;
}

std::optional<Datagram> MulticastSocket::ReceiveOne(bool* more) {
  std::array<uint8_t, 65536> bytes;
  alignas(cmsghdr) std::array<char, 64> control;
  sockaddr_in from{};
  iovec vector{bytes.data(), bytes.size()};
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof(from);
  message.msg_iov = &vector;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t size = recvmsg(fd_, &message, 0);
  *more = size >= 0;
  if (size < 0) return std::nullopt;
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&dropped_, CMSG_DATA(c), sizeof(dropped_));
    }
  }
  senders_.insert(from.sin_addr.s_addr);
  if (!IsOurs(bytes.data(), static_cast<size_t>(size))) return std::nullopt;
  return Datagram{Bytes(bytes.begin() + kHeaderBytes, bytes.begin() + size), from.sin_addr.s_addr};
}

std::optional<Datagram> MulticastSocket::Receive(Duration timeout) {
  const TimePoint deadline = Clock::now() + timeout;
  for (;;) {
    bool more = true;
    while (more) {
      if (std::optional<Datagram> datagram = ReceiveOne(&more)) return datagram;
    }
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return std::nullopt;
    pollfd waited{fd_, POLLIN, 0};
    poll(&waited, 1, static_cast<int>(left));
  }
}

}  // namespace cairn::deploy
