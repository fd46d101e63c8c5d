#include "deploy/doctor/route.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <functional>

#include "common/core/check.h"

namespace cairn::deploy {
namespace {

class Descriptor {
 public:
  Descriptor(int domain, int type, int protocol) : fd_(socket(domain, type | SOCK_CLOEXEC, protocol)) {
    if (fd_ < 0) ThrowError("cannot make a socket: {}", std::strerror(errno));
  }
  ~Descriptor() { close(fd_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

struct RouteRequest {
  nlmsghdr header;
  rtmsg message;
  rtattr attribute;
  in_addr address;
};

// Index of the interface by which packets to `address` leave, or −errno.
int OutInterface(const std::string& address) {
  const Descriptor netlink(AF_NETLINK, SOCK_RAW, NETLINK_ROUTE);
  RouteRequest request{};
  request.header.nlmsg_len = sizeof(request);
  request.header.nlmsg_type = RTM_GETROUTE;
  request.header.nlmsg_flags = NLM_F_REQUEST;
  request.message.rtm_family = AF_INET;
  request.message.rtm_dst_len = 32;
  request.attribute.rta_type = RTA_DST;
  request.attribute.rta_len = RTA_LENGTH(sizeof(in_addr));
  inet_pton(AF_INET, address.c_str(), &request.address);
  if (send(netlink.fd(), &request, sizeof(request), 0) < 0) return -errno;
  alignas(nlmsghdr) std::array<char, 4096> bytes{};
  const ssize_t size = recv(netlink.fd(), bytes.data(), bytes.size(), 0);
  const auto* answer = reinterpret_cast<const nlmsghdr*>(bytes.data());
  if (size < 0 || !NLMSG_OK(answer, static_cast<size_t>(size))) return -EIO;
  if (answer->nlmsg_type == NLMSG_ERROR) return static_cast<const nlmsgerr*>(NLMSG_DATA(answer))->error;
  int length = static_cast<int>(RTM_PAYLOAD(answer));
  for (const rtattr* a = RTM_RTA(NLMSG_DATA(answer)); RTA_OK(a, length); a = RTA_NEXT(a, length)) {
    int index = 0;
    if (a->rta_type != RTA_OIF) continue;
    std::memcpy(&index, RTA_DATA(a), sizeof(index));
    return index;
  }
  return -ENETUNREACH;
}

// Calls `visit` for each IPv4 address of this host.
void ForEachAddress(const std::function<void(const ifaddrs&, unsigned address)>& visit) {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return;
  for (const ifaddrs* i = first; i != nullptr; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_INET) continue;
    visit(*i, reinterpret_cast<const sockaddr_in*>(i->ifa_addr)->sin_addr.s_addr);
  }
  freeifaddrs(first);
}

}  // namespace

Route FindInterface(const std::string& name) {
  Route route;
  route.interface = name;
  const Descriptor udp(AF_INET, SOCK_DGRAM, 0);
  ifreq request{};
  std::strncpy(request.ifr_name, name.c_str(), IFNAMSIZ - 1);
  if (ioctl(udp.fd(), SIOCGIFFLAGS, &request) != 0) {
    route.error = errno;
    return route;
  }
  route.up = (request.ifr_flags & IFF_UP) != 0;
  route.carrier = (request.ifr_flags & IFF_RUNNING) != 0;
  route.multicast = (request.ifr_flags & IFF_MULTICAST) != 0;
  route.loopback = (request.ifr_flags & IFF_LOOPBACK) != 0;
  if (ioctl(udp.fd(), SIOCGIFMTU, &request) == 0) route.mtu = request.ifr_mtu;
  return route;
}

Route FindRoute(const std::string& address) {
  const int index = OutInterface(address);
  std::array<char, IF_NAMESIZE> name{};
  if (index > 0 && if_indextoname(static_cast<unsigned>(index), name.data()) != nullptr) {
    return FindInterface(name.data());
  }
  Route none;
  none.error = index < 0 ? -index : ENETUNREACH;
  return none;
}

std::string OutwardInterfaces() {
  std::string names;
  ForEachAddress([&](const ifaddrs& i, unsigned) {
    constexpr unsigned kUp = IFF_UP | IFF_RUNNING;
    if ((i.ifa_flags & kUp) != kUp || (i.ifa_flags & IFF_LOOPBACK) != 0) return;
    names += (names.empty() ? "" : " or ") + std::string(i.ifa_name);
  });
  return names.empty() ? "<interface>" : names;
}

bool IsOwnAddress(unsigned address) {
  bool own = false;
  ForEachAddress([&](const ifaddrs&, unsigned mine) { own = own || mine == address; });
  return own;
}

}  // namespace cairn::deploy
