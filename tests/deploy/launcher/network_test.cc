#include "deploy/launcher/network.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/core/check.h"
#include "tests/deploy/launcher/test_support.h"

namespace cairn::deploy {
namespace {

constexpr const char* kGroup = "239.255.76.67";
constexpr uid_t kNobody = 65534;

// Bodies run in child processes, where EXPECT_* would go unseen: each returns 0 or the line that failed.
#define REQUIRE(condition)                                            \
  do {                                                                \
    if (!(condition)) {                                               \
      fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
      return 1;                                                       \
    }                                                                 \
  } while (false)

void ExpectPass(int result) {
  if (result == kNotAllowed) GTEST_SKIP() << "this kernel or container refuses new namespaces";
  EXPECT_EQ(result, 0);
}

void DropRoot() {
  if (geteuid() != 0) return;
  if (setgid(kNobody) != 0 || setuid(kNobody) != 0) _exit(kNotAllowed);
  prctl(PR_SET_DUMPABLE, 1);  // else /proc/self would stay root's
}

bool Allowed(int flags) {
  return InChildProcess([flags] { return unshare(flags) == 0 ? 0 : 1; }) == 0;
}

// A network namespace with loopback down and no route at all.
bool EnterBareNetwork() { return unshare(CLONE_NEWNET) == 0 || unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0; }

// Sends a datagram to the group with ttl 0 and receives it, as LCM does.
bool MulticastWorks() {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(41799);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) != 0) return false;
  ip_mreq membership{};
  inet_pton(AF_INET, kGroup, &membership.imr_multiaddr);
  if (setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) != 0) return false;
  const int ttl = 0;
  setsockopt(fd, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof(ttl));
  const timeval patience{10, 0};
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  name.sin_addr = membership.imr_multiaddr;
  if (sendto(fd, "hello", 5, 0, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) != 5) return false;
  char bytes[16];
  return recv(fd, bytes, sizeof(bytes), 0) == 5;
}

TEST(NetworkTest, WithARouteNothingChanges) {
  if (!HasMulticastRoute(kGroup)) GTEST_SKIP() << "this host has no multicast route";
  const uint64_t before = NetworkInode(getpid());
  const NetworkInfo network = PrepareNetwork(kGroup, 0);
  EXPECT_FALSE(network.is_private);
  EXPECT_EQ(network.inode, before);
}

TEST(NetworkTest, WithoutARouteAUserGetsAPrivateNetworkWhereMulticastWorks) {
  ExpectPass(InChildProcess([] {
    DropRoot();
    if (!Allowed(CLONE_NEWUSER | CLONE_NEWNET)) return kNotAllowed;
    const uint64_t before = NetworkInode(getpid());
    const uid_t uid = geteuid();
    const NetworkInfo network = EnterPrivateNetwork(kGroup);
    REQUIRE(network.is_private && network.user_namespace);
    REQUIRE(network.inode != before && network.inode == NetworkInode(getpid()));
    REQUIRE(geteuid() == uid);
    REQUIRE(HasMulticastRoute(kGroup));
    REQUIRE(MulticastWorks());
    return 0;
  }));
}

TEST(NetworkTest, RootNeedsNoUserNamespace) {
  if (geteuid() != 0 || !Allowed(CLONE_NEWNET)) GTEST_SKIP() << "needs root with CAP_SYS_ADMIN";
  ExpectPass(InChildProcess([] {
    const NetworkInfo network = EnterPrivateNetwork(kGroup);
    REQUIRE(network.is_private && !network.user_namespace);
    REQUIRE(MulticastWorks());
    return 0;
  }));
}

TEST(NetworkTest, PrepareEntersOneOnlyWithoutARoute) {
  ExpectPass(InChildProcess([] {
    if (!EnterBareNetwork()) return kNotAllowed;
    REQUIRE(!HasMulticastRoute(kGroup));
    REQUIRE(PrepareNetwork(kGroup, 0).is_private);
    REQUIRE(!PrepareNetwork(kGroup, 0).is_private);
    return 0;
  }));
}

TEST(NetworkTest, BetweenHostsAMissingRouteIsAnErrorWithTheCure) {
  ExpectPass(InChildProcess([] {
    if (!EnterBareNetwork()) return kNotAllowed;
    try {
      PrepareNetwork(kGroup, 1);
    } catch (const Error& error) {
      REQUIRE(std::string(error.what()).find("ip route add 224.0.0.0/4") != std::string::npos);
      return 0;
    }
    return 1;
  }));
}

TEST(NetworkTest, JoinEntersTheNetworkOfAnotherProcess) {
  ExpectPass(InChildProcess([] {
    DropRoot();
    if (!Allowed(CLONE_NEWUSER | CLONE_NEWNET)) return kNotAllowed;
    int ready[2], finish[2];
    REQUIRE(pipe(ready) == 0 && pipe(finish) == 0);
    const pid_t other = fork();
    if (other == 0) {
      EnterPrivateNetwork(kGroup);
      close(ready[1]);
      close(finish[1]);
      char byte;
      _exit(read(finish[0], &byte, 1) == 0 ? 0 : 1);
    }
    close(ready[1]);
    char byte;
    REQUIRE(read(ready[0], &byte, 1) == 0);  // end of file: the other one has closed its end
    const uint64_t inode = NetworkInode(other);
    REQUIRE(inode != NetworkInode(getpid()));
    JoinNetworkOf(other);
    REQUIRE(NetworkInode(getpid()) == inode);
    REQUIRE(MulticastWorks());
    close(finish[1]);
    return 0;
  }));
}

TEST(NetworkTest, GoneProcessHasNoNetwork) { EXPECT_EQ(NetworkInode(999999999), 0u); }

TEST(NetworkTest, HintShowsTheWayIn) {
  EXPECT_EQ(LookInsideCommand(42, {true, true, 1}), "nsenter -t 42 -U --preserve-credentials -n");
}

}  // namespace
}  // namespace cairn::deploy
