// Strangers on the run's ports, over real LCM: who has no key, who repeats what others said, and other runs.
#include <gtest/gtest.h>

#include <lcm/lcm-cpp.hpp>
#include <thread>

#include "common/bus/bus.h"
#include "common/core/hash.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;

constexpr RunKey kKey{1, 2, 3};
constexpr RunKey kOtherKey{3, 2, 1};

// Its own port block per test, so that leftovers of one test cannot reach another.
BusConfig Config(int block, const std::optional<RunKey>& key, int64_t run_id = 42) {
  BusConfig config;
  config.base_port = 21500 + 10 * block;
  config.run_id = run_id;
  config.session = RandomId();
  config.key = key;
  return config;
}

template <typename Done>
bool PollUntil(Bus* bus, Done done) {
  const TimePoint deadline = Clock::now() + std::chrono::seconds(5);
  while (!done() && Clock::now() < deadline) bus->Poll(milliseconds(10));
  return done();
}

// A process of the run that takes statuses; they bear their number as session.
struct Receiver {
  explicit Receiver(const BusConfig& config) : bus(config) {
    bus.Subscribe<ActorStatus>(Plane::kExperience, kStatusChannel,
                               [this](const ActorStatus& m, const FrameInfo&) { heard.push_back(m.session); });
    bus.CheckPlanes();
  }
  Bus bus;
  std::vector<int64_t> heard;
};

void Say(Bus* bus, int64_t number) { bus->Publish(Plane::kExperience, kStatusChannel, ActorStatus{.session = number}); }

// Plain LCM: keeps the payloads that pass by and sends them again as they are.
class Replayer {
 public:
  explicit Replayer(const BusConfig& config) : lcm_(PlaneUrl(config, Plane::kExperience)) {
    lcm_.subscribe(kStatusChannel, &Replayer::Record, this)->setQueueCapacity(1000);
  }
  size_t Listen(size_t messages) {
    while (recorded_.size() < messages && lcm_.handleTimeout(5000) > 0) {
    }
    return recorded_.size();
  }
  void Repeat() {
    for (const Bytes& frame : recorded_)
      lcm_.publish(kStatusChannel, frame.data(), static_cast<unsigned>(frame.size()));
  }

 private:
  void Record(const lcm::ReceiveBuffer* buffer, const std::string&) {
    const auto* data = static_cast<const uint8_t*>(buffer->data);
    recorded_.emplace_back(data, data + buffer->data_size);
  }
  lcm::LCM lcm_;
  std::vector<Bytes> recorded_;
};

TEST(AuthenticationTest, ForgersAreIgnoredAndCountedWhileAllTrueMessagesArrive) {
  Receiver receiver(Config(0, kKey));
  Bus sender(Config(0, kKey)), keyless(Config(0, std::nullopt)), guesser(Config(0, kOtherKey));
  std::vector<int64_t> said;
  for (int i = 0; i < 100; ++i) {
    Say(&keyless, -1);
    Say(&guesser, -2);
    Say(&sender, i);
    said.push_back(i);
  }
  EXPECT_TRUE(PollUntil(&receiver.bus, [&] { return receiver.heard.size() >= said.size(); }));
  EXPECT_EQ(receiver.heard, said);
  EXPECT_EQ(receiver.bus.stats().of(FrameFault::kNoKey), 100);
  EXPECT_EQ(receiver.bus.stats().of(FrameFault::kTag), 100);
  EXPECT_EQ(receiver.bus.stats().refused, 200);
}

TEST(AuthenticationTest, ReplayedMessagesAreIgnoredAndCounted) {
  Receiver receiver(Config(1, kKey));
  Replayer replayer(receiver.bus.config());
  Bus sender(Config(1, kKey));
  std::vector<int64_t> said;
  const auto speak = [&] {
    for (int i = 0; i < 50; ++i) {
      said.push_back(static_cast<int64_t>(said.size()));
      Say(&sender, said.back());
    }
  };
  speak();
  ASSERT_EQ(replayer.Listen(50), 50u);
  replayer.Repeat();
  speak();
  replayer.Repeat();
  speak();
  EXPECT_TRUE(PollUntil(&receiver.bus, [&] { return receiver.heard.size() >= said.size(); }));
  EXPECT_EQ(receiver.heard, said);
  EXPECT_EQ(receiver.bus.stats().of(FrameFault::kReplay), 100);
}

TEST(AuthenticationTest, ReplayOnAnotherPlaneIsNoMessage) {
  Receiver receiver(Config(2, kKey));
  Replayer replayer(receiver.bus.config());
  Bus sender(Config(2, kKey));
  int control = 0;
  receiver.bus.Subscribe<ActorStatus>(Plane::kControl, kStatusChannel,
                                      [&](const ActorStatus&, const FrameInfo&) { ++control; });
  Say(&sender, 1);
  ASSERT_EQ(replayer.Listen(1), 1u);
  BusConfig shifted = receiver.bus.config();
  shifted.base_port += static_cast<int>(Plane::kControl);  // its first plane is the run's second
  Replayer elsewhere(shifted);
  Bytes frame = Encode(ActorStatus{.session = 1});
  FrameSeal(42, kKey).Seal(Plane::kExperience, {7, 1}, &frame);
  lcm::LCM(PlaneUrl(shifted, Plane::kExperience))
      .publish(kStatusChannel, frame.data(), static_cast<unsigned>(frame.size()));
  EXPECT_TRUE(PollUntil(&receiver.bus, [&] { return receiver.bus.stats().of(FrameFault::kTag) == 1; }));
  EXPECT_EQ(control, 0);
}

TEST(AuthenticationTest, ProcessWithoutAKeyRefusesKeyedMessages) {
  Receiver receiver(Config(3, std::nullopt));
  Bus keyed(Config(3, kKey)), sender(Config(3, std::nullopt));
  Say(&keyed, 1);
  Say(&sender, 2);
  EXPECT_TRUE(PollUntil(&receiver.bus, [&] { return !receiver.heard.empty(); }));
  EXPECT_EQ(receiver.heard, std::vector<int64_t>{2});
  EXPECT_EQ(receiver.bus.stats().of(FrameFault::kKeyed), 1);
}

// One key for two runs, both on the same ports: each hears its own.
TEST(AuthenticationTest, RunsOnOnePortNeverMix) {
  for (const std::optional<RunKey>& key : {std::optional<RunKey>(), std::optional<RunKey>(kKey)}) {
    const int block = key ? 5 : 4;
    Receiver first(Config(block, key, 1)), second(Config(block, key, 2));
    Bus first_sender(Config(block, key, 1)), second_sender(Config(block, key, 2));
    std::vector<int64_t> odd, even;
    for (int i = 0; i < 100; i += 2) {
      Say(&second_sender, i);
      Say(&first_sender, i + 1);
      even.push_back(i);
      odd.push_back(i + 1);
    }
    PollUntil(&first.bus, [&] { return first.heard.size() >= odd.size(); });
    PollUntil(&second.bus, [&] { return second.heard.size() >= even.size(); });
    EXPECT_EQ(first.heard, odd);
    EXPECT_EQ(second.heard, even);
    // The other run's messages and its echoes from the start.
    EXPECT_GE(first.bus.stats().of(FrameFault::kRun), 50);
    EXPECT_EQ(first.bus.stats().refused, first.bus.stats().of(FrameFault::kRun));
  }
}

TEST(AuthenticationTest, EveryHandlerOfAMessageHearsItOnce) {
  Receiver receiver(Config(6, kKey));
  int all = 0;
  receiver.bus.Subscribe<ActorStatus>(Plane::kExperience, "CAIRN_STAT.*",
                                      [&](const ActorStatus&, const FrameInfo&) { ++all; });
  Bus sender(Config(6, kKey));
  Say(&sender, 1);
  EXPECT_TRUE(PollUntil(&receiver.bus, [&] { return all == 1 && receiver.heard.size() == 1; }));
  EXPECT_EQ(receiver.bus.stats().refused, 0);
}

TEST(AuthenticationTest, ThreadsThatPublishAtOnceNeverShareANonce) {
  Receiver receiver(Config(7, kKey));
  Bus sender(Config(7, kKey));
  constexpr int kThreads = 4, kMessages = 200;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < kThreads; ++t) {
      threads.emplace_back([&sender] {
        for (int i = 0; i < kMessages; ++i) Say(&sender, i);
      });
    }
  }
  EXPECT_TRUE(PollUntil(&receiver.bus, [&] { return receiver.heard.size() == kThreads * kMessages; }));
  EXPECT_EQ(receiver.bus.stats().of(FrameFault::kReplay), 0);
}

}  // namespace
}  // namespace cairn
