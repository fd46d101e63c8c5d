#include "deploy/launcher/network.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <net/if.h>
#include <net/route.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "common/core/check.h"

namespace cairn::deploy {
namespace {

constexpr const char* kCure = "sudo ip route add 224.0.0.0/4 dev lo";

// A socket for ioctl and connect.
class UdpSocket {
 public:
  UdpSocket() : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    if (fd_ < 0) ThrowError("cannot make a UDP socket: {}", std::strerror(errno));
  }
  ~UdpSocket() { close(fd_); }
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

bool WriteProc(const char* path, const std::string& text) {
  const int fd = open(path, O_WRONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool written = write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  close(fd);
  return written;
}

// The user keeps name and files: ids map to themselves, and the capabilities in the new namespace suffice for set-up.
void MapIds(uid_t uid, gid_t gid) {
  WriteProc("/proc/self/setgroups", "deny");  // absent on old kernels
  const bool mapped = WriteProc("/proc/self/uid_map", fmt::format("{} {} 1", uid, uid)) &&
                      WriteProc("/proc/self/gid_map", fmt::format("{} {} 1", gid, gid));
  if (!mapped) ThrowError("cannot map user {} into a user namespace: {}", uid, std::strerror(errno));
}

void RaiseLoopback(int fd) {
  ifreq request{};
  std::strncpy(request.ifr_name, "lo", IFNAMSIZ - 1);
  bool ok = ioctl(fd, SIOCGIFFLAGS, &request) == 0;
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | IFF_RUNNING);
  ok = ok && ioctl(fd, SIOCSIFFLAGS, &request) == 0;
  if (!ok) ThrowError("cannot raise the loopback interface: {}", std::strerror(errno));
}

void SetAddress(sockaddr* to, const char* address) {
  auto* in = reinterpret_cast<sockaddr_in*>(to);
  in->sin_family = AF_INET;
  inet_pton(AF_INET, address, &in->sin_addr);
}

// ip route add 224.0.0.0/4 dev lo
void AddMulticastRoute(int fd) {
  rtentry route{};
  char device[] = "lo";
  SetAddress(&route.rt_dst, "224.0.0.0");
  SetAddress(&route.rt_genmask, "240.0.0.0");
  route.rt_flags = RTF_UP;
  route.rt_dev = device;
  if (ioctl(fd, SIOCADDRT, &route) != 0 && errno != EEXIST) {
    ThrowError("cannot add a multicast route: {}", std::strerror(errno));
  }
}

// Root needs no user namespace, and in one it would lose its rights on other users' files. 0 or errno.
int Unshare(bool* user_namespace) {
  const uid_t uid = geteuid();
  const gid_t gid = getegid();
  *user_namespace = false;
  if (unshare(CLONE_NEWNET) == 0) return 0;
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return errno;
  *user_namespace = true;
  MapIds(uid, gid);
  return 0;
}

std::string NamespacePath(pid_t pid, const char* kind) { return fmt::format("/proc/{}/ns/{}", pid, kind); }

uint64_t Inode(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 ? info.st_ino : 0;
}

void Join(pid_t pid, const char* kind, int type) {
  const std::string path = NamespacePath(pid, kind);
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool joined = fd >= 0 && setns(fd, type) == 0;
  const int error = errno;
  if (fd >= 0) close(fd);
  if (!joined) ThrowError("cannot enter {}: {}", path, std::strerror(error));
}

}  // namespace

bool HasMulticastRoute(const std::string& group) {
  const UdpSocket socket;
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(1);
  inet_pton(AF_INET, group.c_str(), &name.sin_addr);
  return connect(socket.fd(), reinterpret_cast<const sockaddr*>(&name), sizeof(name)) == 0;
}

NetworkInfo PrepareNetwork(const std::string& group, int ttl) {
  if (HasMulticastRoute(group)) return {false, false, NetworkInode(getpid())};
  if (ttl > 0) {
    ThrowError(
        "transport.group = {}: no multicast route, and transport.ttl = {} needs one to the other hosts; add it: "
        "sudo ip route add 224.0.0.0/4 dev <interface>",
        group, ttl);
  }
  return EnterPrivateNetwork(group);
}

NetworkInfo EnterPrivateNetwork(const std::string& group) {
  bool user_namespace = false;
  if (const int error = Unshare(&user_namespace); error != 0) {
    ThrowError("transport.group = {}: no multicast route, and the kernel refuses a private network ({}); add one: {}",
               group, std::strerror(error), kCure);
  }
  const UdpSocket socket;
  RaiseLoopback(socket.fd());
  AddMulticastRoute(socket.fd());
  if (!HasMulticastRoute(group)) {
    ThrowError("transport.group = {}: no way to it in the private network either; add a route: {}", group, kCure);
  }
  return {true, user_namespace, NetworkInode(getpid())};
}

void JoinNetworkOf(pid_t pid) {
  if (Inode(NamespacePath(pid, "user")) != Inode(NamespacePath(getpid(), "user"))) Join(pid, "user", CLONE_NEWUSER);
  if (NetworkInode(pid) != NetworkInode(getpid())) Join(pid, "net", CLONE_NEWNET);
}

uint64_t NetworkInode(pid_t pid) { return Inode(NamespacePath(pid, "net")); }

std::string LookInsideCommand(pid_t pid, const NetworkInfo& network) {
  return fmt::format("{}nsenter -t {} {}-n", network.user_namespace || geteuid() == 0 ? "" : "sudo ", pid,
                     network.user_namespace ? "-U --preserve-credentials " : "");
}

}  // namespace cairn::deploy
