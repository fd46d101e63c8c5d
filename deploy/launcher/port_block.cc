#include "deploy/launcher/port_block.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "common/bus/bus.h"
#include "common/core/check.h"

namespace cairn::deploy {
namespace {

constexpr int kLastPort = 65535;

// A bound UDP socket, or -1 with errno.
int BindUdp(uint32_t address, int port, bool reuse) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) ThrowError("cannot make a UDP socket: {}", std::strerror(errno));
  const int on = 1;
  if (reuse) setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_addr.s_addr = htonl(address);
  name.sin_port = htons(static_cast<uint16_t>(port));
  if (bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) == 0) return fd;
  const int error = errno;
  close(fd);
  errno = error;
  return -1;
}

// LCM binds with SO_REUSEADDR: it fails only on a port that someone else holds without it.
bool PlanesFree(int base_port) {
  for (int port = base_port; port < base_port + kNumPlanes; ++port) {
    const int fd = BindUdp(INADDR_ANY, port, true);
    if (fd < 0) return false;
    close(fd);
  }
  return true;
}

// The guard of a block, -1 when it or one of the planes' ports is taken.
int TryBlock(int base_port) {
  const int guard = BindUdp(INADDR_LOOPBACK, base_port + kNumPlanes, false);
  if (guard < 0 && errno != EADDRINUSE) {
    ThrowError("cannot bind UDP port {}: {}", base_port + kNumPlanes, std::strerror(errno));
  }
  if (guard < 0 || PlanesFree(base_port)) return guard;
  close(guard);
  return -1;
}

}  // namespace

PortBlock PortBlock::Claim(int base_port) {
  for (int base = base_port; base + kPortBlock - 1 <= kLastPort; base += kPortBlock) {
    const int guard = TryBlock(base);
    if (guard < 0) continue;
    std::string note;
    if (base != base_port)
      note = fmt::format("UDP ports from {} on are taken; using {} to {}", base_port, base, base + 4);
    return {guard, base, std::move(note)};
  }
  ThrowError("transport.base_port = {}: every block of {} UDP ports from there to {} is taken", base_port, kPortBlock,
             kLastPort);
}

PortBlock::PortBlock(int fd, int base_port, std::string note)
    : fd_(fd), base_port_(base_port), note_(std::move(note)) {}

PortBlock::PortBlock(PortBlock&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), base_port_(other.base_port_), note_(std::move(other.note_)) {}

PortBlock::~PortBlock() {
  if (fd_ >= 0) close(fd_);
}

}  // namespace cairn::deploy
