#include "common/bus/frame.h"

#include <gtest/gtest.h>

namespace cairn {
namespace {

constexpr RunKey kKey{1, 2, 3};
constexpr RunKey kOtherKey{1, 2, 4};
constexpr int64_t kRun = 7;

// Encoded once: each encoding has a new time in it.
const Bytes kMessage = Encode(Echo{1, 4});

Bytes Sealed(const FrameSeal& seal, Plane plane = Plane::kControl, const FrameInfo& info = {1, 2}) {
  Bytes frame = kMessage;
  seal.Seal(plane, info, &frame);
  return frame;
}

std::optional<FrameFault> FaultOf(const FrameSeal& seal, ByteSpan frame) {
  return seal.Open(Plane::kControl, frame).fault;
}

TEST(FrameTest, GivesBackWhatWasSealed) {
  for (const FrameSeal& seal : {FrameSeal(kRun), FrameSeal(kRun, kKey)}) {
    const Bytes frame = Sealed(seal);
    const OpenedFrame opened = seal.Open(Plane::kControl, frame);
    ASSERT_FALSE(opened.fault);
    EXPECT_EQ(opened.info.session, 1);
    EXPECT_EQ(opened.info.counter, 2u);
    EXPECT_EQ(Bytes(opened.message.begin(), opened.message.end()), kMessage);
    EXPECT_EQ(opened.message.size(), frame.size() - seal.trailer_bytes());
    EXPECT_LE(seal.trailer_bytes(), kTrailerBytes);
  }
}

TEST(FrameTest, NamesWhatIsWrong) {
  for (const std::optional<RunKey>& key : {std::optional<RunKey>(), std::optional<RunKey>(kKey)}) {
    const FrameSeal seal(kRun, key);
    const Bytes frame = Sealed(seal);
    EXPECT_EQ(FaultOf(FrameSeal(kRun + 1, key), frame), FrameFault::kRun);
    EXPECT_EQ(FaultOf(seal, {}), FrameFault::kTooShort);
    EXPECT_EQ(FaultOf(seal, ByteSpan(frame).last(seal.trailer_bytes() - 1)), FrameFault::kTooShort);
    EXPECT_EQ(FaultOf(seal, ByteSpan(frame).first(frame.size() - 1)), FrameFault::kMagic);
    Bytes other = frame;
    other[frame.size() - seal.trailer_bytes() + 7] ^= 1;
    EXPECT_EQ(FaultOf(seal, other), FrameFault::kProtocol);
    other = frame;
    other[0] ^= 1;
    EXPECT_EQ(FaultOf(seal, other), key ? FrameFault::kTag : FrameFault::kChecksum);
  }
}

TEST(FrameTest, KeyedAndUnkeyedRefuseEachOther) {
  const FrameSeal keyed(kRun, kKey), plain(kRun);
  EXPECT_EQ(FaultOf(keyed, Sealed(plain)), FrameFault::kNoKey);
  EXPECT_EQ(FaultOf(plain, Sealed(keyed)), FrameFault::kKeyed);
}

TEST(FrameTest, WrongKeyIsRefused) {
  EXPECT_EQ(FaultOf(FrameSeal(kRun, kKey), Sealed(FrameSeal(kRun, kOtherKey))), FrameFault::kTag);
}

TEST(FrameTest, ForgedTagIsRefused) {
  const FrameSeal seal(kRun, kKey);
  Bytes frame = Sealed(seal);
  std::fill(frame.end() - 16, frame.end(), uint8_t{0});
  EXPECT_EQ(FaultOf(seal, frame), FrameFault::kTag);
}

// What a forger makes who holds a frame of one run and writes the number of another into it.
TEST(FrameTest, FrameOfAnotherRunDoesNotPassUnderAChangedRunId) {
  const FrameSeal seal(kRun, kKey);
  Bytes frame = Sealed(FrameSeal(kRun + 1, kKey));
  frame[frame.size() - seal.trailer_bytes() + 15] = kRun;
  EXPECT_EQ(FaultOf(seal, frame), FrameFault::kTag);
}

TEST(FrameTest, FrameHoldsOnItsPlaneOnly) {
  const FrameSeal seal(kRun, kKey);
  const Bytes frame = Sealed(seal, Plane::kTables);
  EXPECT_FALSE(seal.Open(Plane::kTables, frame).fault);
  EXPECT_EQ(seal.Open(Plane::kControl, frame).fault, FrameFault::kTag);
}

TEST(FrameTest, TagDependsOnSessionAndCounter) {
  const FrameSeal seal(kRun, kKey);
  const auto tag = [&](const FrameInfo& info) {
    const Bytes frame = Sealed(seal, Plane::kControl, info);
    return Bytes(frame.end() - 16, frame.end());
  };
  EXPECT_EQ(tag({1, 2}), tag({1, 2}));
  EXPECT_NE(tag({1, 2}), tag({1, 3}));
  EXPECT_NE(tag({1, 2}), tag({2, 2}));
}

// The tag of another implementation: BLAKE2b and AES-GCM of Python's hashlib and OpenSSL.
TEST(FrameTest, TagIsThatOfTheDescribedConstruction) {
  Bytes frame{'m'};
  FrameSeal(kRun, kKey).Seal(Plane::kTables, {5, 9}, &frame);
  EXPECT_EQ(Bytes(frame.end() - 16, frame.end()),
            Bytes({0x27, 0xd4, 0x39, 0x7b, 0xce, 0x95, 0xaa, 0x60, 0x26, 0x2a, 0xed, 0x07, 0x7e, 0x4a, 0x85, 0x86}));
}

TEST(FrameTest, ContextsOfSoundSendersAreKeptAndNoOthers) {
  const FrameSeal receiver(kRun, kKey, 1);
  PeerContexts peers;
  for (int64_t session = 2; session < 100; ++session) {
    Bytes forged = Sealed(receiver, Plane::kControl, {session, 1});
    forged.back() ^= 1;
    EXPECT_EQ(receiver.Open(Plane::kControl, forged, &peers).fault, FrameFault::kTag);
  }
  EXPECT_EQ(peers.size(), 0u);
  for (uint64_t counter = 1; counter <= 3; ++counter) {
    const Bytes frame = Sealed(FrameSeal(kRun, kKey, 2), Plane::kControl, {2, counter});
    EXPECT_FALSE(receiver.Open(Plane::kControl, frame, &peers).fault);
    EXPECT_EQ(peers.size(), 1u);
    Bytes forged = frame;
    forged[0] ^= 1;
    EXPECT_EQ(receiver.Open(Plane::kControl, forged, &peers).fault, FrameFault::kTag);
  }
  EXPECT_FALSE(receiver.Open(Plane::kControl, Sealed(receiver, Plane::kControl, {1, 1}), &peers).fault);
  EXPECT_EQ(peers.size(), 1u) << "the own session needs none";
}

TEST(FrameTest, ContextOfASenderThatWasForgottenIsMadeAgain) {
  const FrameSeal receiver(kRun, kKey);
  PeerContexts peers;
  for (int64_t session = 1; session <= 1100; ++session) {
    EXPECT_FALSE(receiver.Open(Plane::kControl, Sealed(receiver, Plane::kControl, {session, 1}), &peers).fault);
  }
  EXPECT_EQ(peers.size(), 1024u);
  EXPECT_FALSE(receiver.Open(Plane::kControl, Sealed(receiver, Plane::kControl, {1, 2}), &peers).fault);
}

TEST(FrameTest, FlippedBitsAreRefusedEverywhere) {
  const FrameSeal seal(kRun, kKey);
  const Bytes frame = Sealed(seal);
  for (size_t bit = 0; bit < 8 * frame.size(); ++bit) {
    Bytes flipped = frame;
    flipped[bit / 8] = static_cast<uint8_t>(flipped[bit / 8] ^ (1u << (bit % 8)));
    EXPECT_TRUE(FaultOf(seal, flipped)) << bit;
  }
}

}  // namespace
}  // namespace cairn
