#include "common/config/lcm_url.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/core/check.h"

namespace cairn {
namespace {

TEST(LcmUrlTest, ReadsGroupFirstPortAndTtl) {
  EXPECT_EQ(ParseLcmUrl("udpm://239.255.76.67:7700?ttl=1"), (TransportConfig{"239.255.76.67", 7700, 1}));
  EXPECT_EQ(ParseLcmUrl("udpm://224.0.0.1:1024?ttl=255"), (TransportConfig{"224.0.0.1", 1024, 255}));
  EXPECT_EQ(ParseLcmUrl("udpm://239.1.2.3:65530"), (TransportConfig{"239.1.2.3", 65530, 0}));
}

TEST(LcmUrlTest, ReadsABroker) {
  const TransportConfig transport = ParseLcmUrl("tcpq://node-1.cluster:7700");
  EXPECT_EQ(transport.broker, "node-1.cluster:7700");
  EXPECT_EQ(ToLcmUrl(transport), "tcpq://node-1.cluster:7700");
  EXPECT_EQ(ParseLcmUrl(ToLcmUrl(transport)), transport);
}

TEST(LcmUrlTest, BrokersOnLoopbackAloneStayOnThisHost) {
  for (const char* url :
       {"tcpq://localhost:7700", "tcpq://127.0.0.1:7700", "tcpq://127.255.0.9:1", "udpm://239.1.2.3:7700"}) {
    EXPECT_FALSE(ParseLcmUrl(url).leaves_host()) << url;
  }
  for (const char* url :
       {"tcpq://10.0.0.1:7700", "tcpq://127.example.org:7700", "tcpq://node1:7700", "udpm://239.1.2.3:7700?ttl=1"}) {
    EXPECT_TRUE(ParseLcmUrl(url).leaves_host()) << url;
  }
}

TEST(LcmUrlTest, WritesWhatItReads) {
  const TransportConfig transport{"239.1.2.3", 7705, 3};
  EXPECT_EQ(ToLcmUrl(transport), "udpm://239.1.2.3:7705?ttl=3");
  EXPECT_EQ(ParseLcmUrl(ToLcmUrl(transport)), transport);
}

TEST(LcmUrlTest, AnythingElseIsRefusedNamingUrlAndRule) {
  for (const char* url : {"",
                          "udpm",
                          "udpm://",
                          "tcpq://239.1.2.3:7700?ttl=1",
                          "tcpq://",
                          "tcpq://host",
                          "tcpq://:7700",
                          "tcpq://host:0",
                          "tcpq://host:65536",
                          "tcpq://host:7700:7700",
                          "tcpq://ho st:7700",
                          "tcpq://[::1]:7700",
                          "tcpq://a/b:7700",
                          "UDPM://239.1.2.3:7700",
                          " udpm://239.1.2.3:7700",
                          "udpm://239.1.2.3",
                          "udpm://239.1.2.3?ttl=1",
                          "udpm://239.1.2.3:",
                          "udpm://239.1.2.3:1023",
                          "udpm://239.1.2.3:65531",
                          "udpm://239.1.2.3:77x",
                          "udpm://239.1.2.3:-7700",
                          "udpm://239.1.2.3: 7700",
                          "udpm://239.1.2.3:7700:7701",
                          "udpm://239.1.2.3:7700/",
                          "udpm://239.1.2.3:99999999999999999999",
                          "udpm://10.0.0.1:7700",
                          "udpm://239.1.2:7700",
                          "udpm://host:7700",
                          "udpm://:7700",
                          "udpm://[ff02::1]:7700",
                          "udpm://239.1.2.3:7700?",
                          "udpm://239.1.2.3:7700?ttl",
                          "udpm://239.1.2.3:7700?ttl=",
                          "udpm://239.1.2.3:7700?ttl=256",
                          "udpm://239.1.2.3:7700?ttl=-1",
                          "udpm://239.1.2.3:7700?ttl=1 ",
                          "udpm://239.1.2.3:7700?TTL=1",
                          "udpm://239.1.2.3:7700?recv_buf_size=4000000",
                          "udpm://239.1.2.3:7700?ttl=1&recv_buf_size=4000000",
                          "udpm://239.1.2.3:7700?ttl=1&ttl=0",
                          "udpm://239.1.2.3:7700?ttl=1?ttl=1"}) {
    try {
      ParseLcmUrl(url);
      ADD_FAILURE() << url;
    } catch (const UsageError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(std::string("--lcm-url ") + url + ": "));
      EXPECT_THAT(error.what(), testing::HasSubstr("it must be udpm://GROUP:PORT?ttl=T"));
    }
  }
}

}  // namespace
}  // namespace cairn
