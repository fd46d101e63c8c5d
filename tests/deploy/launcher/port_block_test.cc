#include "deploy/launcher/port_block.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/core/check.h"

namespace cairn::deploy {
namespace {

// Far from the default ports, so that runs beside the tests do not matter.
constexpr int kBase = 41700;

// A socket of somebody else.
class ForeignSocket {
 public:
  ForeignSocket(int port, bool reuse) : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    const int on = 1;
    if (reuse) setsockopt(fd_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_port = htons(static_cast<uint16_t>(port));
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&name), sizeof(name)), 0) << port;
  }
  ~ForeignSocket() { close(fd_); }
  ForeignSocket(const ForeignSocket&) = delete;

 private:
  int fd_;
};

TEST(PortBlockTest, TakesThePortAskedFor) {
  const PortBlock block = PortBlock::Claim(kBase);
  EXPECT_EQ(block.base_port(), kBase);
  EXPECT_EQ(block.note(), "");
}

TEST(PortBlockTest, SecondRunGetsTheNextBlockAndSaysSo) {
  const PortBlock first = PortBlock::Claim(kBase);
  const PortBlock second = PortBlock::Claim(kBase);
  EXPECT_EQ(second.base_port(), kBase + 5);
  EXPECT_THAT(second.note(), testing::HasSubstr("41705"));
  EXPECT_EQ(PortBlock::Claim(kBase).base_port(), kBase + 10);
}

TEST(PortBlockTest, BlockIsFreeAgainAfterItsHolder) {
  { const PortBlock block = PortBlock::Claim(kBase); }
  EXPECT_EQ(PortBlock::Claim(kBase).base_port(), kBase);
}

TEST(PortBlockTest, MovedFromBlockHoldsNothing) {
  PortBlock first = PortBlock::Claim(kBase);
  const PortBlock second = std::move(first);
  EXPECT_EQ(PortBlock::Claim(kBase).base_port(), kBase + 5);
}

TEST(PortBlockTest, PlanePortOfSomebodyElseSkipsTheBlock) {
  const ForeignSocket foreign(kBase + 2, false);
  EXPECT_EQ(PortBlock::Claim(kBase).base_port(), kBase + 5);
}

TEST(PortBlockTest, PlanePortSharedByLcmDoesNot) {
  const ForeignSocket lcm(kBase + 1, true);
  EXPECT_EQ(PortBlock::Claim(kBase).base_port(), kBase);
}

TEST(PortBlockTest, NoFreeBlockIsAnErrorThatNamesTheOption) {
  const ForeignSocket foreign(65531, false);
  try {
    PortBlock::Claim(65530);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("transport.base_port = 65530"));
  }
}

}  // namespace
}  // namespace cairn::deploy
