// Planes over LCM's own broker (tcpq), and what happens when that is missing, dies, or waits for someone slow.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <numeric>
#include <thread>

#include "common/bus/broker_connection.h"
#include "common/bus/bus.h"
#include "common/core/hash.h"
#include "tests/testing/lcm_broker.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;
using testing::LcmBroker;

// A TCP socket connected to, or (port 0) listening on, this host.
class Tcp {
 public:
  explicit Tcp(const std::string& address = "") : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (address.empty()) {
      EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&name), sizeof name), 0);
      EXPECT_EQ(listen(fd_, 1), 0);
    } else {
      name.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.find(':') + 1))));
      EXPECT_EQ(connect(fd_, reinterpret_cast<sockaddr*>(&name), sizeof name), 0);
    }
  }
  ~Tcp() { close(fd_); }
  Tcp(const Tcp&) = delete;
  Tcp& operator=(const Tcp&) = delete;

  std::string address() const {
    sockaddr_in name{};
    socklen_t length = sizeof name;
    getsockname(fd_, reinterpret_cast<sockaddr*>(&name), &length);
    return "127.0.0.1:" + std::to_string(ntohs(name.sin_port));
  }
  void Write(uint32_t value) const {
    value = htonl(value);
    EXPECT_EQ(send(fd_, &value, sizeof value, 0), 4);
  }
  void Write(const std::string& text) const {
    Write(static_cast<uint32_t>(text.size()));
    EXPECT_EQ(send(fd_, text.data(), text.size(), 0), static_cast<ssize_t>(text.size()));
  }
  int fd() const { return fd_; }

 private:
  int fd_;
};

template <typename Done>
bool PollUntil(Bus* bus, Done done) {
  const TimePoint deadline = Clock::now() + seconds(20);
  while (!done() && Clock::now() < deadline) bus->Poll(milliseconds(5));
  return done();
}

TEST(BrokerProbeTest, SaysWhatIsWrongWithWhatAnswers) {
  std::string nobody;
  {
    const Tcp listening;
    nobody = listening.address();
  }
  EXPECT_EQ(ProbeBroker(nobody), "Connection refused");
  EXPECT_THAT(ProbeBroker("no-such-host.invalid:7700"), HasSubstr("cannot find host 'no-such-host.invalid'"));
  const Tcp silent;
  EXPECT_THAT(ProbeBroker(silent.address()), HasSubstr("said nothing"));
  const Tcp other;
  std::jthread answer([&other] {
    const int fd = accept(other.fd(), nullptr, nullptr);
    EXPECT_GT(send(fd, "SSH-2.0-rest", 12, 0), 0);
    close(fd);
  });
  EXPECT_EQ(ProbeBroker(other.address()), "it is no LCM broker");
}

// A process without a broker waits and says so; nothing throws, blocks or aborts.
TEST(BrokerProbeTest, BusWithoutBrokerDropsAndTellsWhy) {
  std::string nobody;
  {
    const Tcp listening;
    nobody = listening.address();
  }
  BusConfig config;
  config.broker = nobody;
  Bus bus(config);
  bus.Subscribe<ActorStatus>(Plane::kExperience, kStatusChannel, [](const ActorStatus&, const FrameInfo&) {});
  for (int i = 0; i < 3; ++i) bus.Publish(Plane::kExperience, kStatusChannel, ActorStatus{});
  EXPECT_TRUE(PollUntil(&bus, [&] { return bus.stats().dropped == 3; }));
  ASSERT_TRUE(bus.outage());
  EXPECT_EQ(bus.outage()->reason, "Connection refused");
}

class BrokerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!LcmBroker::Missing().empty()) GTEST_SKIP() << LcmBroker::Missing();
    broker_ = std::make_unique<LcmBroker>(22950);
  }

  BusConfig Config(int64_t run_id = 42) const {
    BusConfig config;
    config.broker = broker_->address();
    config.run_id = run_id;
    config.session = RandomId();
    return config;
  }

  std::unique_ptr<LcmBroker> broker_;
};

TEST_F(BrokerTest, KeepsPlanesAndRunsApart) {
  Bus receiver(Config()), sender(Config()), stranger(Config(43));
  std::vector<int64_t> sessions;
  int control = 0;
  receiver.Subscribe<ActorStatus>(Plane::kExperience, kStatusChannel,
                                  [&](const ActorStatus& m, const FrameInfo&) { sessions.push_back(m.session); });
  receiver.Subscribe<Control>(Plane::kControl, kControlChannel, [&](Control&&, const FrameInfo&) { ++control; });
  receiver.CheckPlanes();
  stranger.Publish(Plane::kExperience, kStatusChannel, ActorStatus{.session = 1});
  EXPECT_TRUE(PollUntil(&receiver, [&] { return receiver.stats().refused == 1; }));
  sender.Publish(Plane::kExperience, kStatusChannel, ActorStatus{.session = 2});
  sender.Publish(Plane::kTelemetry, kLearnerChannel, LearnerTelemetry{});
  sender.Publish(Plane::kControl, kControlChannel, Control{});
  EXPECT_TRUE(PollUntil(&receiver, [&] { return control == 1 && !sessions.empty(); }));
  EXPECT_EQ(sessions, std::vector<int64_t>{2});
  EXPECT_EQ(PlaneUrl(receiver.config(), Plane::kTelemetry), broker_->url());
}

// LCM's own publish mixes the bytes of threads here (its issue 614).
TEST_F(BrokerTest, ManyThreadsPublishWithoutLoss) {
  Bus receiver(Config()), sender(Config());
  constexpr int kThreads = 4, kEach = 300;
  std::vector<int> received(kThreads, 0);
  receiver.Subscribe<TableChunk>(Plane::kTables, kTableChunkChannel, [&](const TableChunk& chunk, const FrameInfo&) {
    // In order, for each of them.
    EXPECT_EQ(chunk.chunk, received[chunk.hash]++);
  });
  receiver.CheckPlanes();
  {
    std::vector<std::jthread> threads;
    for (uint64_t t = 0; t < kThreads; ++t) {
      threads.emplace_back([&sender, t] {
        for (int i = 0; i < kEach; ++i) {
          const int bytes = i % 10 == 0 ? 50000 : 500;
          sender.Publish(Plane::kTables, kTableChunkChannel,
                         TableChunk{t, bytes * kEach, i, bytes, Bytes(static_cast<size_t>(bytes), 1)});
        }
      });
    }
  }
  const auto total = [&] { return std::accumulate(received.begin(), received.end(), 0); };
  EXPECT_TRUE(PollUntil(&receiver, [&] { return total() == kThreads * kEach; })) << total();
  EXPECT_EQ(receiver.stats().refused + receiver.stats().dropped + sender.stats().dropped, 0);
}

TEST_F(BrokerTest, ComesBackWithTheBroker) {
  Bus receiver(Config()), sender(Config());
  int received = 0;
  receiver.Subscribe<ActorStatus>(Plane::kExperience, "CAIRN_STA.*",
                                  [&](const ActorStatus&, const FrameInfo&) { ++received; });
  receiver.CheckPlanes();
  EXPECT_FALSE(receiver.outage());
  broker_->Kill();
  EXPECT_TRUE(PollUntil(&receiver, [&] { return receiver.outage().has_value(); }));
  sender.Publish(Plane::kExperience, kStatusChannel, ActorStatus{});  // goes nowhere
  EXPECT_EQ(received, 0);
  broker_->Start();
  EXPECT_TRUE(PollUntil(&receiver, [&] { return !receiver.outage() && !sender.outage(); }));
  // The broker may still be taking the subscription up.
  EXPECT_TRUE(PollUntil(&receiver, [&] {
    sender.Publish(Plane::kExperience, kStatusChannel, ActorStatus{});
    return received > 0;
  }));
}

// Whoever subscribes and does not read stalls the broker's thread of each publisher on that plane: those drop, nobody
// waits, and the other planes go on. (While it lasts nobody may connect, or the broker stalls them all:
// docs/operations.md.)
TEST_F(BrokerTest, SlowWatcherStallsTelemetryOnly) {
  Bus receiver(Config()), sender(Config());
  int received = 0, telemetry = 0;
  receiver.Subscribe<ActorStatus>(Plane::kExperience, kStatusChannel,
                                  [&](const ActorStatus&, const FrameInfo&) { ++received; });
  receiver.Subscribe<TableChunk>(Plane::kTelemetry, "CAIRN_LEARNER",
                                 [&](const TableChunk&, const FrameInfo&) { ++telemetry; });
  receiver.CheckPlanes();
  EXPECT_TRUE(PollUntil(&receiver, [&] {
    sender.Publish(Plane::kExperience, kStatusChannel, ActorStatus{});
    return received > 0;
  }));
  {
    const Tcp slow(broker_->address());
    for (const uint32_t word : {0x287617fbu, 0x0100u, 2u}) slow.Write(word);
    slow.Write("CAIRN_LEARNER");
    const TableChunk large{1, 50000, 0, 50000, Bytes(50000, 1)};
    EXPECT_TRUE(PollUntil(&receiver, [&] {
      for (int i = 0; i < 20; ++i) sender.Publish(Plane::kTelemetry, kLearnerChannel, large);
      return sender.stats().dropped > 0;
    }));
    EXPECT_FALSE(sender.outage());  // the experience plane is what counts
    const int before = received;
    for (int i = 0; i < 100; ++i) sender.Publish(Plane::kExperience, kStatusChannel, ActorStatus{});
    EXPECT_TRUE(PollUntil(&receiver, [&] { return received >= before + 100; }));
    telemetry = 0;
  }
  EXPECT_TRUE(PollUntil(&receiver, [&] { return telemetry > 0; }));  // it has gone, and all is well again
}

}  // namespace
}  // namespace cairn
