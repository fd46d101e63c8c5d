#include "deploy/doctor/network_checks.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "common/bus/broker_connection.h"
#include "common/bus/bus.h"
#include "common/core/check.h"
#include "common/core/hash.h"
#include "deploy/doctor/multicast_socket.h"
#include "deploy/doctor/route.h"
#include "deploy/launcher/network.h"

namespace cairn::deploy {
namespace {

constexpr size_t kLcmHeaderBytes = 8 + 32;  // and the longest channel name
constexpr size_t kUdpHeaderBytes = 28;      // with IP's
constexpr size_t kSmallBytes = 100;

int64_t ReadNumber(const std::string& path) {
  std::ifstream file(path);
  int64_t number = -1;
  file >> number;
  return number;
}

std::string RouteCure(const Subject& subject, const char* verb) {
  const std::string interface = subject.transport.ttl == 0 ? "lo" : OutwardInterfaces();
  return fmt::format("sudo ip route {} 224.0.0.0/4 dev {}", verb, interface);
}

std::string CureOfNoRoute(const Subject& subject) {
  const std::string route = RouteCure(subject, "add");
  return subject.transport.ttl == 0 && !FindInterface("lo").up ? "sudo ip link set lo up && " + route : route;
}

// `cairn train` on one host helps itself.
Finding WithoutRoute(const Subject& subject) {
  const std::string& group = subject.transport.group;
  const std::string cure = CureOfNoRoute(subject);
  const std::string why = fmt::format("no way to {}", group);
  if (subject.transport.ttl > 0) return Fail("route", why + ", and ttl ≥ 1 needs one to the other hosts", cure);
  try {
    EnterPrivateNetwork(group);
  } catch (const Error& error) {
    return Fail("route", why + ", and the kernel refuses a private network",
                cure + " (or: sudo sysctl -w kernel.unprivileged_userns_clone=1)");
  }
  return Warn("route",
              why +
                  ": cairn train makes a private network for itself, in which the next lines look; what is started "
                  "by hand needs the route",
              cure);
}

Finding Outward(const Subject& subject, const Route& route) {
  const std::string by = fmt::format("{} by {}", subject.transport.group, route.interface);
  if (route.loopback) {
    return Fail("route", by + ": with ttl ≥ 1 messages shall reach other hosts, and this interface leads to none",
                RouteCure(subject, "replace"));
  }
  if (!route.carrier) {
    return Fail("route", by + ", which has no carrier",
                fmt::format("plug it in, or: {}", RouteCure(subject, "replace")));
  }
  if (!route.multicast) {
    return Fail("route", by + ", on which multicast is off",
                fmt::format("sudo ip link set dev {} multicast on", route.interface));
  }
  return Ok("route", by);
}

// Every byte of a plane's largest message: LCM's, UDP's and IP's headers as well.
int LargestPacket(int ttl) { return static_cast<int>(MaxMessageBytes(ttl) + kLcmHeaderBytes + kUdpHeaderBytes); }

// One plane's socket and what became of its echo.
class Echo {
 public:
  Echo(const Subject& subject, int port)
      : group_(subject.transport.group), socket_(group_, port, subject.transport.ttl) {}

  bool Returns(size_t bytes, const std::string& address) {
    if (!socket_.failed_step().empty()) return false;
    // Several times, for the case that the network is busy; each time on its own number.
    for (int attempt = 0; attempt < 5; ++attempt) {
      Bytes payload(bytes);
      const int64_t nonce = RandomId();
      std::memcpy(payload.data(), &nonce, sizeof(nonce));
      send_error_ = socket_.SendTo(address, payload);
      if (send_error_ != 0) return false;
      const TimePoint deadline = Clock::now() + std::chrono::milliseconds(200);
      while (const std::optional<Datagram> datagram = socket_.Receive(deadline - Clock::now())) {
        if (datagram->payload == payload) return true;
      }
    }
    return false;
  }
  bool ReturnsFromGroup(size_t bytes) { return Returns(bytes, group_); }

  const MulticastSocket& socket() const { return socket_; }
  int send_error() const { return send_error_; }

 private:
  std::string group_;
  MulticastSocket socket_;
  int send_error_ = 0;
};

// Why a socket could not be made ready.
Finding WhyNotOpen(const MulticastSocket& socket, int port) {
  const std::string what =
      fmt::format("port {}: cannot {}: {}", port, socket.failed_step(), std::strerror(socket.error()));
  if (socket.error() == EADDRINUSE) return Fail("echo", what, "free the port, see the line 'ports'");
  if (socket.error() == ENOBUFS) {
    return Fail("echo", what + " (net.ipv4.igmp_max_memberships)", "sudo sysctl -w net.ipv4.igmp_max_memberships=20");
  }
  return Fail("echo", what, "sudo ip link set lo up; see the line 'route'");
}

// An echo that is lost: smaller and straighter ways tell where.
Finding WhyLost(Echo* echo, const Subject& subject, int port, size_t bytes) {
  const std::string what =
      fmt::format("port {}: a message of {} bytes to {} does not come back", port, bytes, subject.transport.group);
  const std::string firewall = FirewallCure(subject.transport.base_port, subject.transport.base_port + kNumPlanes - 1);
  if (echo->send_error() == EPERM) return Fail("echo", what + ": a firewall forbids to send it", firewall);
  if (echo->send_error() != 0) {
    return Fail("echo", what + ": " + std::strerror(echo->send_error()), "see the lines 'route' and 'loopback'");
  }
  if (echo->ReturnsFromGroup(kSmallBytes)) {
    return Fail("echo", what + ", one of 100 bytes does: fragments or large datagrams are dropped",
                "sudo sysctl -w net.ipv4.ipfrag_high_thresh=4194304; if that does not help, " + firewall);
  }
  if (echo->Returns(kSmallBytes, "127.0.0.1")) {
    return Fail(
        "echo", what + ", one to 127.0.0.1 does: multicast is not looped back to this host, or a firewall drops it",
        "let 224.0.0.0/4 pass: sudo nft insert rule inet TABLE CHAIN ip daddr 224.0.0.0/4 accept (sudo nft list "
        "ruleset shows TABLE and CHAIN of the rule that drops it)");
  }
  return Fail("echo", what + ", nor one to 127.0.0.1: a firewall drops them", firewall);
}

}  // namespace

std::string FirewallCure(int first, int last) {
  return fmt::format(
      "let the ports pass: sudo nft insert rule inet TABLE CHAIN udp dport {}-{} accept (sudo nft list ruleset shows "
      "TABLE and CHAIN of the rule that drops them; rules that fit: deploy/cairn.nft)",
      first, last);
}

Finding CheckLoopback() {
  const Route loopback = FindInterface("lo");
  if (loopback.error == 0 && loopback.up) return Ok("loopback", "lo is up");
  return Fail("loopback", "lo is down", "sudo ip link set lo up");
}

Finding CheckRoute(const Subject& subject) {
  const Route route = FindRoute(subject.transport.group);
  if (route.error == ENETUNREACH) return WithoutRoute(subject);
  if (route.error != 0) {
    return Fail("route", fmt::format("{}: {}: a route forbids it", subject.transport.group, std::strerror(route.error)),
                RouteCure(subject, "replace"));
  }
  if (subject.transport.ttl > 0) return Outward(subject, route);
  return Ok("route", fmt::format("{} by {}", subject.transport.group, route.interface));
}

Finding CheckFragments(const Subject& subject) {
  constexpr int64_t kLeast = 1 << 20;
  const Route route = FindRoute(subject.transport.group);
  const int packet = LargestPacket(subject.transport.ttl);
  const int64_t pool = ReadNumber("/proc/sys/net/ipv4/ipfrag_high_thresh");
  const int64_t seconds = ReadNumber("/proc/sys/net/ipv4/ipfrag_time");
  const std::string seen =
      fmt::format("packets of up to {} bytes, mtu {}, pool {} bytes for {} s", packet, route.mtu, pool, seconds);
  if (subject.transport.ttl > 0 && route.error == 0 && route.mtu < packet) {
    return Warn("fragments", seen + ": each message is cut in two, and lost with either half",
                fmt::format("sudo ip link set dev {} mtu 1500, on all hosts and the switch between", route.interface));
  }
  if (pool >= 0 && pool < kLeast) {
    return Warn("fragments", seen + ": too small a pool to put fragments together",
                "sudo sysctl -w net.ipv4.ipfrag_high_thresh=4194304");
  }
  return Ok("fragments", seen + (route.mtu < packet ? ", put together on this host" : ", none are cut"));
}

Finding CheckEcho(const Subject& subject) {
  const auto bytes = static_cast<size_t>(MaxMessageBytes(subject.transport.ttl));
  for (int plane = 0; plane < kNumPlanes; ++plane) {
    const int port = subject.transport.base_port + plane;
    Echo echo(subject, port);
    if (echo.ReturnsFromGroup(bytes)) continue;
    if (!echo.socket().failed_step().empty()) return WhyNotOpen(echo.socket(), port);
    return WhyLost(&echo, subject, port, bytes);
  }
  return Ok("echo", fmt::format("{} bytes come back on ports {} to {}", bytes, subject.transport.base_port,
                                subject.transport.base_port + kNumPlanes - 1));
}

Finding CheckBroker(const Subject& subject) {
  std::string seen;
  for (const std::string& broker : {subject.transport.broker, subject.transport.telemetry_broker}) {
    if (broker.empty()) continue;
    const std::string fault = ProbeBroker(broker);
    if (!fault.empty()) {
      return Fail("broker", fmt::format("tcpq://{}: {}", broker, fault),
                  fmt::format("on that host: {}; let TCP port {} pass its firewall", BrokerCommand(broker),
                              broker.substr(broker.find(':') + 1)));
    }
    seen += fmt::format("{}tcpq://{} answers", seen.empty() ? "" : ", ", broker);
  }
  return Ok("broker", seen + "; multicast is not used");
}

}  // namespace cairn::deploy
