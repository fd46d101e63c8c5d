#include "deploy/doctor/peer.h"

#include <arpa/inet.h>
#include <poll.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <deque>

#include "common/bus/receive_buffer.h"
#include "common/core/check.h"
#include "common/core/clock.h"
#include "common/core/hash.h"
#include "deploy/doctor/multicast_socket.h"
#include "deploy/doctor/network_checks.h"
#include "deploy/doctor/route.h"

namespace cairn::deploy {
namespace {

constexpr int64_t kProbePeriodUs = 500;
constexpr int64_t kStatePeriodUs = 50'000;
constexpr int64_t kLingerUs = 500'000;      // of states after the end, for a peer that has missed the last ones
constexpr int64_t kSilenceUs = 10'000'000;  // after which a peer is taken for dead

class Measurement {
 public:
  Measurement(const Subject& subject, int probes, double patience_s)
      : session_(RandomId(), probes), deadline_us_(MonotonicUs() + static_cast<int64_t>(1e6 * patience_s)) {
    for (int plane = 0; plane < kNumPlanes; ++plane) {
      sockets_.emplace_back(subject.transport.group, subject.transport.base_port + plane, subject.transport.ttl);
    }
  }

  // True when both sides have counted.
  bool Run() {
    int64_t finished_us = 0;
    for (;;) {
      const int64_t now_us = MonotonicUs();
      Wait(now_us);
      Receive();
      Speak(now_us);
      session_.Tick(now_us);
      if (session_.finished() && finished_us == 0) finished_us = now_us;
      if (finished_us != 0 && now_us - finished_us > kLingerUs) return true;
      if (finished_us == 0 && GivenUp(now_us)) return false;
    }
  }

  const PeerSession& session() const { return session_; }
  const std::string& address() const { return address_; }
  // What this host's own buffers dropped.
  uint32_t dropped() const {
    uint32_t sum = 0;
    for (const MulticastSocket& socket : sockets_) sum += socket.dropped();
    return sum;
  }
  const MulticastSocket* broken_socket() const {
    for (const MulticastSocket& socket : sockets_) {
      if (!socket.failed_step().empty()) return &socket;
    }
    return nullptr;
  }

 private:
  bool GivenUp(int64_t now_us) const {
    if (!session_.paired()) return now_us > deadline_us_;
    return now_us - session_.last_heard_us() > kSilenceUs;
  }

  void Wait(int64_t now_us) {
    std::array<pollfd, kNumPlanes> fds{};
    for (size_t i = 0; i < fds.size(); ++i) fds[i] = {sockets_[i].fd(), POLLIN, 0};
    const int64_t next = session_.sending() ? next_probe_us_ : next_state_us_;
    const int64_t us = std::max<int64_t>(0, std::min(next, next_state_us_) - now_us);
    const timespec timeout{us / 1'000'000, (us % 1'000'000) * 1000};
    ppoll(fds.data(), fds.size(), &timeout, nullptr);
  }

  void Receive() {
    for (int plane = 0; plane < kNumPlanes; ++plane) {
      MulticastSocket& socket = sockets_[static_cast<size_t>(plane)];
      while (const std::optional<Datagram> datagram = socket.Receive(Duration::zero())) {
        const bool known = session_.heard();
        const std::optional<Bytes> reply = session_.Handle(datagram->payload, plane, MonotonicUs(), WallUs());
        if (!known && session_.heard()) address_ = inet_ntoa(in_addr{datagram->address});
        if (reply && !reply->empty()) socket.Send(*reply);
      }
    }
  }

  void Speak(int64_t now_us) {
    if (now_us >= next_state_us_) {
      next_state_us_ = now_us + kStatePeriodUs;
      const Bytes state = session_.State();
      for (MulticastSocket& socket : sockets_) socket.Send(state);
    }
    // Paced; what a late wake-up missed is not made up for in a burst.
    if (now_us < next_probe_us_) return;
    next_probe_us_ = std::max(next_probe_us_ + kProbePeriodUs, now_us - 4 * kProbePeriodUs);
    const auto plane = static_cast<size_t>(session_.sent() % kNumPlanes);
    if (const std::optional<Bytes> probe = session_.NextProbe(MonotonicUs())) sockets_[plane].Send(*probe);
  }

  PeerSession session_;
  std::deque<MulticastSocket> sockets_;
  std::string address_;
  int64_t deadline_us_;
  int64_t next_state_us_ = 0;
  int64_t next_probe_us_ = 0;
};

Finding NoPeer(const Subject& subject, const Measurement& measurement, double patience_s) {
  const int first = subject.transport.base_port;
  const std::string ports = FirewallCure(first, first + kNumPlanes - 1);
  if (measurement.session().paired()) {
    return Fail("peer", measurement.address() + " fell silent in the middle", "start it again on both hosts");
  }
  if (measurement.session().heard()) {
    return Fail("peer", measurement.address() + " is heard, but does not hear this host",
                "look at the other lines here and there: ttl and route of this host; on the other one " + ports);
  }
  return Fail("peer",
              fmt::format("nobody answers on {} ports {} to {} within {:.0f} s", subject.transport.group, first,
                          first + kNumPlanes - 1, patience_s),
              fmt::format("run cairn doctor --peer on the other host at the same time, with the same group, port and a "
                          "ttl of 1 or more; give both a route by the interface between them (sudo ip route replace "
                          "224.0.0.0/4 dev {}); {}; let the switch pass multicast (IGMP snooping)",
                          OutwardInterfaces(), ports));
}

// One direction. A plane of which nothing arrives is a closed port, not chance.
Finding Loss(const std::string& name, const Subject& subject, const PeerResult& result,
             const std::array<int, kNumPlanes>& arrived, double share, const std::string& where) {
  std::string seen = fmt::format("{:.2f} % of {} lost", 100 * share, result.probes);
  for (size_t plane = 0; plane < kNumPlanes; ++plane) {
    if (arrived[plane] > 0 || result.probes_of_plane[plane] == 0) continue;
    const int port = subject.transport.base_port + static_cast<int>(plane);
    return Fail(name,
                fmt::format("{}; nothing arrives on port {} ({})", seen, port, PlaneName(static_cast<Plane>(plane))),
                where + ": " + FirewallCure(subject.transport.base_port, subject.transport.base_port + kNumPlanes - 1));
  }
  if (share <= 0.01) return Ok(name, seen);
  return {name, share <= 0.2 ? FindingState::kWarn : FindingState::kFail, seen,
          where +
              ": look for a firewall that limits UDP (sudo nft list ruleset), a bad cable or a switch that slows "
              "multicast (ip -s link shows drops and errors), or a receive buffer that is clipped"};
}

Finding RoundTrip(const PeerResult& result) {
  const double median = result.round_trip_us(0.5);
  const std::string seen = fmt::format("median {:.0f} us, 99 % below {:.0f} us, {} probes answered", median,
                                       result.round_trip_us(0.99), result.round_trips_us.size());
  if (median < 20'000) return Ok("round trip", seen);
  return Warn("round trip", seen + ": LOCKSTEP waits for this in each round", "a nearer network, or schedule=ASYNC");
}

Finding PeerClock(const PeerResult& result) {
  if (!result.clock_offset_us) return Warn("peer clock", "unknown: no probe was answered", "see the lines above");
  const std::string seen = fmt::format("{:+.1f} ms beside this host's", 1e-3 * *result.clock_offset_us);
  if (std::abs(*result.clock_offset_us) < 1e6) return Ok("peer clock", seen);
  return Warn("peer clock", seen + ": only time stamps show it", "sudo timedatectl set-ntp true on both hosts");
}

}  // namespace

PeerReport MeasurePeer(const Subject& subject, int probes, double patience_s) {
  Measurement measurement(subject, probes, patience_s);
  PeerReport report;
  if (const MulticastSocket* broken = measurement.broken_socket()) {
    report.findings.push_back(Fail("peer",
                                   fmt::format("cannot {}: {}", broken->failed_step(), std::strerror(broken->error())),
                                   "see the lines above"));
    return report;
  }
  const bool finished = measurement.Run();
  report.address = measurement.address();
  if (!finished) {
    report.findings.push_back(NoPeer(subject, measurement, patience_s));
    return report;
  }
  const PeerResult result = measurement.session().Result();
  if (measurement.session().peer_probes() != probes) {
    report.findings.push_back(Fail(
        "peer",
        fmt::format("{} sends {} probes, this host {}", report.address, measurement.session().peer_probes(), probes),
        "the same --probes on both hosts"));
    return report;
  }
  report.findings = {Ok("peer", report.address),
                     Loss("loss to peer", subject, result, result.sent_arrived, result.lost_to_peer(), "on the peer"),
                     Loss("loss from peer", subject, result, result.received, result.lost_from_peer(), "on this host"),
                     RoundTrip(result), PeerClock(result)};
  if (measurement.dropped() > 0) {
    report.findings.push_back(
        Warn("peer buffer", fmt::format("{} datagrams did not fit this host's receive buffer", measurement.dropped()),
             "see the line 'receive buffer'; or the host is too busy"));
  }
  report.result = result;
  return report;
}

}  // namespace cairn::deploy
