#include "common/bus/reliable_stream.h"

#include <gtest/gtest.h>

#include <deque>

#include "common/core/random.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;

// A message whose bytes 16… hold its sequence number.
Bytes Numbered(int64_t sequence, size_t size = 100) {
  Bytes bytes(size, 0);
  for (size_t i = 0; i < 8; ++i) bytes[16 + i] = static_cast<uint8_t>(static_cast<uint64_t>(sequence) >> (8 * i));
  return bytes;
}

int64_t Number(const Bytes& bytes) {
  uint64_t value = 0;
  for (size_t i = 0; i < 8; ++i) value |= static_cast<uint64_t>(bytes[16 + i]) << (8 * i);
  return static_cast<int64_t>(value);
}

TEST(ReliableStreamTest, DeliversExactlyOnceInOrderOverALossyReorderingChannel) {
  RandomStream random(3, RandomPurpose::kTest);
  std::deque<int64_t> wire;
  ReliableSender sender([&](const Bytes& bytes) {
    if (random.Uniform() < 0.2) return;  // lost
    if (!wire.empty() && random.Uniform() < 0.1) {
      wire.insert(wire.end() - 1, Number(bytes));  // overtakes
    } else {
      wire.push_back(Number(bytes));
    }
    if (random.Uniform() < 0.05) wire.push_back(Number(bytes));  // doubled
  });
  ReliableReceiver receiver;
  std::vector<int64_t> delivered;
  TimePoint now{};
  constexpr int64_t kMessages = 2000;
  int64_t pushed = 0;
  for (int tick = 0; tick < 200000 && receiver.received() < kMessages; ++tick) {
    now += milliseconds(1);
    if (pushed < kMessages && sender.buffered_bytes() < 5000) {
      ASSERT_EQ(sender.next_sequence(), ++pushed);
      sender.Push(Numbered(pushed), now);
    }
    sender.Poll(now);
    while (!wire.empty()) {
      if (receiver.Accept(wire.front()) == ReliableReceiver::Verdict::kNew) delivered.push_back(wire.front());
      wire.pop_front();
    }
    if (random.Uniform() > 0.2) sender.Acknowledge(receiver.received(), 5000, 0, now);
  }
  ASSERT_EQ(delivered.size(), static_cast<size_t>(kMessages));
  for (int64_t i = 0; i < kMessages; ++i) EXPECT_EQ(delivered[static_cast<size_t>(i)], i + 1);
  sender.Acknowledge(kMessages, 5000, 0, now);
  EXPECT_TRUE(sender.idle());
  EXPECT_EQ(sender.buffered_bytes(), 0);
  EXPECT_GT(sender.resent(), 0);
}

TEST(ReliableStreamTest, KeepsOutstandingBytesInsideTheWindow) {
  int on_the_way = 0;
  ReliableSender sender([&](const Bytes&) { ++on_the_way; });
  TimePoint now{};
  sender.Acknowledge(0, 250, 0, now);
  for (int i = 1; i <= 10; ++i) sender.Push(Numbered(i), now);
  EXPECT_EQ(on_the_way, 2);
  sender.Acknowledge(1, 250, 0, now);
  EXPECT_EQ(on_the_way, 3);
}

TEST(ReliableStreamTest, SendsNothingTwiceWhileAcknowledgementsComeInTime) {
  ReliableSender sender([](const Bytes&) {});
  TimePoint now{};
  for (int i = 1; i <= 100; ++i) {
    sender.Push(Numbered(i), now);
    now += milliseconds(10);
    sender.Acknowledge(i, 1000, 0, now);
  }
  EXPECT_EQ(sender.sent(), 100);
  EXPECT_EQ(sender.resent(), 0);
}

TEST(ReliableStreamTest, IgnoresAcknowledgementsOfWhatWasNeverSent) {
  ReliableSender sender([](const Bytes&) {});
  TimePoint now{};
  sender.Push(Numbered(1), now);
  sender.Acknowledge(5, 1000, 0, now);
  EXPECT_FALSE(sender.idle());
}

TEST(ReliableStreamTest, OneMessageLargerThanTheWindowStillTravels) {
  int on_the_way = 0;
  ReliableSender sender([&](const Bytes&) { ++on_the_way; });
  TimePoint now{};
  sender.Acknowledge(0, 10, 0, now);
  sender.Push(Numbered(1), now);
  EXPECT_EQ(on_the_way, 1);
}

}  // namespace
}  // namespace cairn
