#include "common/bus/bus.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/bus/blob_assembler.h"
#include "common/core/check.h"
#include "common/core/hash.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;

// Its own port block per test, so that leftovers of one test cannot reach another.
BusConfig Config(int block, int64_t run_id = 42) {
  BusConfig config;
  config.base_port = 21000 + 10 * block;
  config.run_id = run_id;
  config.session = RandomId();
  return config;
}

template <typename Done>
void PollUntil(Bus* bus, Done done) {
  const TimePoint deadline = Clock::now() + std::chrono::seconds(5);
  while (!done() && Clock::now() < deadline) bus->Poll(milliseconds(10));
}

TEST(BusTest, DeliversTypedMessagesOfItsRunOnly) {
  Bus receiver(Config(0)), sender(Config(0)), stranger(Config(0, 43));
  std::vector<int64_t> sessions;
  receiver.Subscribe<ActorStatus>(Plane::kExperience, kStatusChannel,
                                  [&](const ActorStatus& m, const FrameInfo&) { sessions.push_back(m.session); });
  receiver.CheckPlanes();
  stranger.Publish(Plane::kExperience, kStatusChannel, ActorStatus{.session = 1});
  sender.Publish(Plane::kExperience, kStatusChannel, ActorStatus{.session = 2});
  PollUntil(&receiver, [&] { return !sessions.empty(); });
  EXPECT_EQ(sessions, std::vector<int64_t>{2});
  EXPECT_EQ(receiver.stats().refused, 1);
}

TEST(BusTest, PlanesDoNotHearEachOther) {
  Bus receiver(Config(1)), sender(Config(1));
  int heard = 0, control = 0;
  receiver.Subscribe<ActorStatus>(Plane::kExperience, ".*", [&](const ActorStatus&, const FrameInfo&) { ++heard; });
  receiver.Subscribe<ActorStatus>(Plane::kControl, ".*", [&](const ActorStatus&, const FrameInfo&) { ++control; });
  sender.Publish(Plane::kTelemetry, kStatusChannel, ActorStatus{});
  sender.Publish(Plane::kControl, kStatusChannel, ActorStatus{});
  PollUntil(&receiver, [&] { return control == 1; });
  EXPECT_EQ(control, 1);
  EXPECT_EQ(heard, 0);
}

TEST(BusTest, LosesNothingInABurstOfLargeMessages) {
  Bus receiver(Config(2)), sender(Config(2));
  int received = 0;
  receiver.Subscribe<TableChunk>(Plane::kTables, kTableChunkChannel,
                                 [&](const TableChunk&, const FrameInfo&) { ++received; });
  receiver.CheckPlanes();
  const TableChunk chunk{.hash = 1, .total_bytes = 50000, .chunk = 0, .chunk_bytes = 50000, .data = Bytes(50000, 1)};
  constexpr int kMessages = 20;  // 1 MB: a quarter of the receive buffer
  for (int i = 0; i < kMessages; ++i) sender.Publish(Plane::kTables, kTableChunkChannel, chunk);
  PollUntil(&receiver, [&] { return received == kMessages; });
  EXPECT_EQ(received, kMessages);
}

TEST(BusTest, GarbageDatagramsAreCountedAndDropped) {
  Bus receiver(Config(3)), sender(Config(3));
  int received = 0;
  receiver.Subscribe<ActorStatus>(Plane::kExperience, ".*", [&](const ActorStatus&, const FrameInfo&) { ++received; });
  receiver.CheckPlanes();
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(receiver.config().base_port));
  inet_pton(AF_INET, receiver.config().group.c_str(), &to.sin_addr);
  // LCM's short header, then: a channel with rubbish, a channel without NUL, nothing at all.
  const std::string header = std::string("LC02") + std::string(4, '\0');
  for (const std::string& body : {header + "X" + std::string(1, '\0') + "rubbish", header + "no end", header,
                                  std::string("short"), std::string(2000, 'x')}) {
    sendto(fd, body.data(), body.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  close(fd);
  sender.Publish(Plane::kExperience, kStatusChannel, ActorStatus{});
  PollUntil(&receiver, [&] { return received == 1; });
  EXPECT_EQ(received, 1);
  EXPECT_GE(receiver.stats().refused, 1);
}

TEST(BusTest, PollReturnsAfterItsTimeout) {
  Bus bus(Config(4));
  bus.Subscribe<ActorStatus>(Plane::kControl, ".*", [](const ActorStatus&, const FrameInfo&) {});
  EXPECT_EQ(bus.Poll(milliseconds(1)), 0);
}

TEST(BlobTest, AssemblesChunksInAnyOrderAndRefusesAWrongHash) {
  const Bytes blob{1, 2, 3, 4, 5, 6, 7};
  const uint64_t hash = ContentHash(blob.data(), blob.size());
  const auto chunk = [&](uint64_t h, int index) {
    const size_t begin = static_cast<size_t>(index) * 3;
    const size_t end = std::min<size_t>(blob.size(), begin + 3);
    return TableChunk{
        h, 7, index, 3,
        Bytes(blob.begin() + static_cast<std::ptrdiff_t>(begin), blob.begin() + static_cast<std::ptrdiff_t>(end))};
  };
  BlobAssembler assembler(hash);
  assembler.Add(chunk(hash, 2));
  assembler.Add(chunk(hash + 1, 0));
  EXPECT_EQ(assembler.FirstGap(), std::make_pair(0, 2));
  assembler.Add(chunk(hash, 0));
  assembler.Add(chunk(hash, 0));
  EXPECT_FALSE(assembler.complete());
  assembler.Add(chunk(hash, 1));
  ASSERT_TRUE(assembler.complete());
  EXPECT_EQ(assembler.bytes(), blob);

  BlobAssembler fooled(hash + 1);
  for (int i = 0; i < 3; ++i) fooled.Add(chunk(hash + 1, i));
  EXPECT_FALSE(fooled.complete());
  EXPECT_EQ(fooled.FirstGap(), std::make_pair(0, 0)) << "it asks for all again";
}

}  // namespace
}  // namespace cairn
