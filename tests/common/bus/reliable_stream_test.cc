#include "common/bus/reliable_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>

#include "common/core/random.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Receiver = ReliableReceiver<int64_t>;

MATCHER_P2(Gap, first, last, "") { return arg.first == first && arg.last == last; }

// A message whose bytes 24… hold its sequence number.
Bytes Numbered(int64_t sequence, size_t size = 100) {
  Bytes bytes(size, 0);
  for (size_t i = 0; i < 8; ++i) bytes[24 + i] = static_cast<uint8_t>(static_cast<uint64_t>(sequence) >> (8 * i));
  return bytes;
}

int64_t Number(const Bytes& bytes) {
  uint64_t value = 0;
  for (size_t i = 0; i < 8; ++i) value |= static_cast<uint64_t>(bytes[24 + i]) << (8 * i);
  return static_cast<int64_t>(value);
}

// A stream over a simulated wire with loss both ways, delay, overtaking and doubling.
class LossyStream {
 public:
  LossyStream(double loss, int64_t seed) : loss_(loss), random_(static_cast<uint64_t>(seed), RandomPurpose::kTest) {}

  // Pushes `messages` messages and runs until all are delivered; false when that takes too long.
  bool Run(int64_t messages) {
    const int64_t goal = receiver.received() + messages;
    for (int tick = 0; tick < 400000 && receiver.received() < goal; ++tick) {
      now += milliseconds(1);
      if (sender.next_sequence() <= goal && sender.next_sequence() < receiver.received() + 200) {
        sender.Push(Numbered(sender.next_sequence()), now);
      }
      sender.Poll(now);
      Deliver();
      if (tick % 5 == 0 && random_.Uniform() >= loss_) Acknowledge();
    }
    Acknowledge();
    return receiver.received() == goal;
  }

  // The receiving process dies and another goes on from `received`.
  bool RestartReceiver(int64_t received) {
    receiver = Receiver(received);
    delivered.resize(static_cast<size_t>(received));
    wire_.clear();
    durable = received;
    return sender.Rewind(received, now);
  }

  ReliableSender sender{[this](const Bytes& bytes) { Transmit(Number(bytes)); }};
  Receiver receiver;
  std::vector<int64_t> delivered;
  int64_t durable = INT64_MAX;
  TimePoint now{};

 private:
  void Transmit(int64_t number) {
    if (random_.Uniform() < loss_) return;
    if (!wire_.empty() && random_.Uniform() < 0.02) {
      wire_.insert(wire_.end() - 1, number);  // overtakes
    } else {
      wire_.push_back(number);
    }
    if (random_.Uniform() < 0.01) wire_.push_back(number);  // doubled
  }

  void Deliver() {
    for (; !wire_.empty(); wire_.pop_front()) receiver.Accept(wire_.front(), wire_.front());
    while (const auto number = receiver.Take()) delivered.push_back(*number);
  }

  void Acknowledge() {
    receiver.Announce(sender.last_sequence());
    sender.Acknowledge({receiver.received(), std::min(durable, receiver.received()), 5000, 0, receiver.Gaps(64)}, now);
  }

  double loss_;
  RandomStream random_;
  std::deque<int64_t> wire_;
};

TEST(ReliableStreamTest, DeliversExactlyOnceInOrderAndResendsLittleMoreThanWasLost) {
  for (const double loss : {0.0, 0.01, 0.05, 0.2}) {
    LossyStream stream(loss, 3);
    ASSERT_TRUE(stream.Run(5000)) << loss;
    for (size_t i = 0; i < stream.delivered.size(); ++i) ASSERT_EQ(stream.delivered[i], static_cast<int64_t>(i) + 1);
    EXPECT_EQ(stream.sender.sent(), 5000);
    EXPECT_LE(static_cast<double>(stream.sender.resent()), 5000 * (1.3 * loss / (1 - loss) + 0.001)) << loss;
    EXPECT_GE(static_cast<double>(stream.sender.resent()), 5000 * 0.8 * loss) << loss;
  }
}

TEST(ReliableStreamTest, ARestartedReceiverGetsEverythingThatWasNotDurable) {
  LossyStream stream(0.05, 4);
  stream.durable = 300;
  ASSERT_TRUE(stream.Run(1000));
  EXPECT_TRUE(stream.sender.idle());
  EXPECT_EQ(stream.sender.buffered_bytes(), 700 * 100) << "kept until they are durable";
  ASSERT_TRUE(stream.RestartReceiver(400));
  ASSERT_TRUE(stream.Run(1000));
  ASSERT_EQ(stream.delivered.size(), 1400u);
  for (size_t i = 0; i < stream.delivered.size(); ++i) ASSERT_EQ(stream.delivered[i], static_cast<int64_t>(i) + 1);
}

TEST(ReliableStreamTest, ARewindBehindWhatTheRingHoldsIsRefused) {
  ReliableSender sender([](const Bytes&) {}, 250);
  TimePoint now{};
  for (int i = 1; i <= 10; ++i) sender.Push(Numbered(i), now);
  sender.Acknowledge({10, 0, 5000, 0, {}}, now);
  EXPECT_EQ(sender.buffered_bytes(), 200) << "the bound counts more than durability";
  EXPECT_FALSE(sender.Rewind(7, now));
  EXPECT_FALSE(sender.Rewind(11, now)) << "never sent";
  EXPECT_TRUE(sender.idle());
  EXPECT_TRUE(sender.Rewind(8, now));
  EXPECT_FALSE(sender.idle());
  EXPECT_EQ(sender.resent(), 2);
}

TEST(ReliableStreamTest, WhatIsMissingIsSentAgainOnlyAfterARoundTrip) {
  int resent = 0;
  ReliableSender sender([&](const Bytes& bytes) { resent += Number(bytes) == 2 ? 1 : 0; });
  TimePoint now{};
  sender.Acknowledge({0, 0, 5000, 0, {}}, now);
  for (int i = 1; i <= 5; ++i) sender.Push(Numbered(i), now);
  const StreamPosition missing{1, 1, 5000, 0, {{2, 2}}};
  for (int ms = 0; ms <= 9; ++ms) sender.Acknowledge(missing, now + milliseconds(ms));
  EXPECT_EQ(resent, 1);
  for (int ms = 11; ms <= 20; ++ms) sender.Acknowledge(missing, now + milliseconds(ms));
  EXPECT_EQ(resent, 2) << "once per round trip (2 ms + 4 x 2 ms before the first measurement)";
}

TEST(ReliableStreamTest, SilenceIsProbedWithOneMessageAndLessAndLessOften) {
  int on_the_way = 0;
  ReliableSender sender([&](const Bytes&) { ++on_the_way; });
  TimePoint now{};
  sender.Acknowledge({0, 0, 5000, 0, {}}, now);
  for (int i = 1; i <= 5; ++i) sender.Push(Numbered(i), now);
  for (int ms = 1; ms <= 1000; ++ms) sender.Poll(now + milliseconds(ms));
  EXPECT_EQ(on_the_way, 5 + 6) << "after 40, 40, 40, 80, 160, 320 ms";
}

TEST(ReliableStreamTest, KeepsOutstandingBytesInsideTheWindow) {
  int on_the_way = 0;
  ReliableSender sender([&](const Bytes&) { ++on_the_way; });
  TimePoint now{};
  sender.Acknowledge({0, 0, 250, 0, {}}, now);
  for (int i = 1; i <= 10; ++i) sender.Push(Numbered(i), now);
  EXPECT_EQ(on_the_way, 2);
  sender.Acknowledge({1, 1, 250, 0, {}}, now);
  EXPECT_EQ(on_the_way, 3);
}

TEST(ReliableStreamTest, SendsNothingTwiceWhileAcknowledgementsComeInTime) {
  ReliableSender sender([](const Bytes&) {});
  TimePoint now{};
  for (int i = 1; i <= 100; ++i) {
    sender.Push(Numbered(i), now);
    now += milliseconds(10);
    sender.Acknowledge({i, i, 1000, 0, {}}, now);
  }
  EXPECT_EQ(sender.sent(), 100);
  EXPECT_EQ(sender.resent(), 0);
  EXPECT_EQ(sender.buffered_bytes(), 0);
}

TEST(ReliableStreamTest, IgnoresAcknowledgementsOfWhatWasNeverSent) {
  ReliableSender sender([](const Bytes&) {});
  TimePoint now{};
  sender.Push(Numbered(1), now);
  sender.Acknowledge({5, 5, 1000, 0, {{1, 1000}}}, now);
  EXPECT_FALSE(sender.idle());
}

TEST(ReliableStreamTest, OneMessageLargerThanTheWindowStillTravels) {
  int on_the_way = 0;
  ReliableSender sender([&](const Bytes&) { ++on_the_way; });
  TimePoint now{};
  sender.Acknowledge({0, 0, 10, 0, {}}, now);
  sender.Push(Numbered(1), now);
  EXPECT_EQ(on_the_way, 1);
}

TEST(ReliableReceiverTest, KnowsWhatIsMissing) {
  Receiver receiver(10);
  EXPECT_THAT(receiver.Gaps(8), IsEmpty());
  EXPECT_EQ(receiver.Accept(10, 0), Receiver::Verdict::kDuplicate);
  EXPECT_EQ(receiver.Accept(13, 13), Receiver::Verdict::kNew);
  EXPECT_EQ(receiver.Accept(13, 13), Receiver::Verdict::kDuplicate);
  EXPECT_EQ(receiver.Accept(15, 15), Receiver::Verdict::kNew);
  EXPECT_FALSE(receiver.Take());
  EXPECT_THAT(receiver.Gaps(8), ElementsAre(Gap(11, 12), Gap(14, 14)));
  receiver.Announce(17);
  EXPECT_THAT(receiver.Gaps(8), ElementsAre(Gap(11, 12), Gap(14, 14), Gap(16, 17)));
  EXPECT_THAT(receiver.Gaps(2), ElementsAre(Gap(11, 12), Gap(14, 14)));
  receiver.Accept(11, 11);
  receiver.Accept(12, 12);
  for (const int64_t expected : {11, 12, 13}) EXPECT_EQ(receiver.Take(), expected);
  EXPECT_FALSE(receiver.Take());
  EXPECT_EQ(receiver.received(), 13);
  EXPECT_THAT(receiver.Gaps(8), ElementsAre(Gap(14, 14), Gap(16, 17)));
}

TEST(ReliableReceiverTest, HoldsABoundedNumberOfEarlyMessages) {
  Receiver receiver;
  for (int64_t i = 2; i < 8194; ++i) ASSERT_EQ(receiver.Accept(i, i), Receiver::Verdict::kNew);
  EXPECT_EQ(receiver.Accept(8194, 0), Receiver::Verdict::kTooEarly);
  EXPECT_EQ(receiver.Accept(1, 1), Receiver::Verdict::kNew) << "the one that the others wait for";
}

}  // namespace
}  // namespace cairn
