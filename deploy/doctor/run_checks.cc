#include "deploy/doctor/run_checks.h"

#include <arpa/inet.h>

#include <deque>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "common/bus/key_file.h"
#include "common/bus/plane.h"
#include "common/core/check.h"
#include "deploy/doctor/multicast_socket.h"
#include "deploy/doctor/route.h"
#include "deploy/launcher/port_block.h"
#include "deploy/launcher/run_directory.h"

namespace cairn::deploy {
namespace {

namespace fs = std::filesystem;

// Inodes of the UDP sockets bound to ports [first, last], as /proc/net/udp has them.
std::set<std::string> SocketsOn(int first, int last) {
  std::set<std::string> inodes;
  std::ifstream file("/proc/net/udp");
  std::string line;
  std::getline(file, line);  // the header
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string slot, local, skipped, inode;
    words >> slot >> local;
    for (int i = 0; i < 7; ++i) words >> skipped;
    words >> inode;
    const size_t colon = local.find(':');
    if (colon == std::string::npos) continue;
    const int port = std::stoi(local.substr(colon + 1), nullptr, 16);
    if (port >= first && port <= last) inodes.insert("socket:[" + inode + "]");
  }
  return inodes;
}

bool HoldsAny(const fs::path& process, const std::set<std::string>& sockets) {
  std::error_code error;
  for (const auto& fd : fs::directory_iterator(process / "fd", error)) {
    if (sockets.count(fs::read_symlink(fd.path(), error).string()) > 0) return true;
  }
  return false;
}

// "process 12 (python3)" for each that can be seen; others' need root.
std::string HoldersOf(int first, int last) {
  const std::set<std::string> sockets = SocketsOn(first, last);
  std::string names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/proc", error)) {
    const std::string pid = entry.path().filename().string();
    if (pid.find_first_not_of("0123456789") != std::string::npos || !HoldsAny(entry.path(), sockets)) continue;
    std::ifstream file(entry.path() / "comm");
    std::string name;
    std::getline(file, name);
    names += fmt::format("{}process {} ({})", names.empty() ? "" : ", ", pid, name);
  }
  return names.empty() ? "a process of another user (sudo ss -ulpn shows it)" : names;
}

// Other hosts that send to the planes' ports while we listen. An actor that waits to be welcomed does it ten times a
// second.
std::string HeardFrom(const TransportConfig& transport) {
  std::deque<MulticastSocket> sockets;
  for (int plane = 0; plane < kNumPlanes; ++plane) {
    sockets.emplace_back(transport.group, transport.base_port + plane, transport.ttl);
    if (!sockets.back().failed_step().empty()) return "";
  }
  std::set<unsigned> senders;
  const TimePoint deadline = Clock::now() + std::chrono::milliseconds(400);
  while (Clock::now() < deadline) {
    for (MulticastSocket& socket : sockets) socket.Receive(std::chrono::milliseconds(20));
  }
  for (const MulticastSocket& socket : sockets) senders.insert(socket.senders().begin(), socket.senders().end());
  std::string names;
  for (const unsigned address : senders) {
    // A host whose only interface is loopback sends from 0.0.0.0.
    if (address == INADDR_ANY || IsOwnAddress(address)) continue;
    names += (names.empty() ? "" : ", ") + std::string(inet_ntoa(in_addr{address}));
  }
  return names;
}

// A plane's port that somebody holds for himself; LCM's sockets share theirs.
bool AnyPlaneTaken(const TransportConfig& transport) {
  for (int plane = 0; plane < kNumPlanes; ++plane) {
    const MulticastSocket socket(transport.group, transport.base_port + plane, transport.ttl);
    if (socket.failed_step() == "bind") return true;
  }
  return false;
}

constexpr const char* kTtlCure =
    "--set transport.ttl=1 for cairn train, ?ttl=1 in the --lcm-url of processes started by hand, the same on all "
    "hosts";

}  // namespace

Finding CheckPorts(const Subject& subject) {
  const int first = subject.transport.base_port;
  const int last = first + kPortBlock - 1;
  if (subject.live_pid != 0) {
    return Ok("ports", fmt::format("{} to {} are held by this run (process {})", first, last, subject.live_pid));
  }
  // Asked before the claim, which binds to them itself.
  const std::string holders = HoldersOf(first, last);
  const PortBlock block = PortBlock::Claim(first);
  if (block.base_port() == first) return Ok("ports", fmt::format("{} to {} are free", first, last));
  const std::string seen = fmt::format("{} to {} are taken by {}", first, last, holders);
  const std::string cure = fmt::format(
      "end it, or take the next free ones: --set transport.base_port={0} (cairn train does so by itself; by "
      "hand --lcm-url 'udpm://{1}:{0}?ttl={2}')",
      block.base_port(), subject.transport.group, subject.transport.ttl);
  // Another run is no fault.
  return AnyPlaneTaken(subject.transport) ? Fail("ports", seen, cure) : Warn("ports", seen, cure);
}

Finding CheckTtl(const Subject& subject) {
  if (!subject.transport.broker.empty()) return Ok("ttl", "not used: messages go over the broker");
  const int ttl = subject.transport.ttl;
  const std::string heard = HeardFrom(subject.transport);
  const std::string hears = heard.empty() ? "" : fmt::format("; hears {}", heard);
  if (ttl > 0) return Ok("ttl", fmt::format("{}: messages reach other hosts{}", ttl, hears));
  if (!heard.empty()) {
    return Fail("ttl", fmt::format("0: messages stay on this host, but {} sends to this run and cannot hear it", heard),
                kTtlCure);
  }
  if (!subject.run_host.empty() && subject.run_host != HostName()) {
    return Fail("ttl", fmt::format("0: the run's messages stay on {}, and this is {}", subject.run_host, HostName()),
                kTtlCure);
  }
  return Ok("ttl", "0: messages stay on this host");
}

Finding TtlForbidsPeer(const Subject&) {
  return Fail("ttl", "0: messages stay on this host, and the peer on another one cannot hear them", kTtlCure);
}

Finding CheckKey(const Subject& subject) {
  const std::string& file = subject.key_file;
  if (!subject.transport.leaves_host()) {
    if (subject.transport.broker.empty()) return Ok("key", "not needed: messages stay on this host");
    return Ok("key", "cairn train makes one: LCM's broker listens on all addresses of its host");
  }
  if (subject.insecure) {
    return Warn("key", "none: whoever can send to the ports can take part in the run",
                "--key FILE in the place of --insecure");
  }
  if (!fs::exists(file)) {
    const std::string why = fmt::format("{}: there is no such file", file);
    const std::string copy = "copy the run's: scp -p HOST:RUN_DIR/key " + file;
    if (subject.key_required) {
      return Fail(
          "key", why,
          fmt::format("{} (or make one for a run by hand: (umask 077; openssl rand -hex 32 > {}))", copy, file));
    }
    return Warn("key", why + ": cairn train makes one, what is started by hand needs one", copy);
  }
  try {
    ReadKeyFile(file);
  } catch (const Error& error) {
    const bool open = (fs::status(file).permissions() & fs::perms(077)) != fs::perms::none;
    return Fail("key", error.what(),
                open ? "chmod 600 " + file : "copy the run's again: scp -p HOST:RUN_DIR/key " + file);
  }
  return Ok("key", file + " is sound and closed to others");
}

}  // namespace cairn::deploy
