#include "deploy/doctor/peer_session.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace cairn::deploy {
namespace {

constexpr int64_t kStepUs = 500;
constexpr int64_t kTripUs = 200;  // one way
constexpr int64_t kPeerClockAheadUs = 7'000'000;

// Two sides and the network between them, on a clock of its own. `lost(from, datagram)` decides; each side also hears
// itself, as in a multicast group.
class PeerSessionTest : public ::testing::Test {
 protected:
  using Lost = std::function<bool(int from, const Bytes&)>;

  void Say(int from, int plane, const Bytes& datagram, const Lost& lost) {
    sides_[from].Handle(datagram, plane, now_us_, now_us_);
    if (lost(from, datagram)) return;
    const int to = 1 - from;
    const std::optional<Bytes> reply =
        sides_[to].Handle(datagram, plane, now_us_ + kTripUs, Wall(to, now_us_ + kTripUs));
    if (!reply || lost(to, *reply)) return;
    sides_[from].Handle(*reply, plane, now_us_ + 2 * kTripUs, Wall(from, now_us_ + 2 * kTripUs));
  }

  static int64_t Wall(int side, int64_t us) { return us + side * kPeerClockAheadUs; }

  // Until both are finished; false when they are not within a minute of their time.
  bool Run(const Lost& lost) {
    for (; now_us_ < 60'000'000; now_us_ += kStepUs) {
      for (int side = 0; side < 2; ++side) {
        if (now_us_ % 50'000 == 0) {
          for (int plane = 0; plane < kNumPlanes; ++plane) Say(side, plane, sides_[side].State(), lost);
        }
        const int plane = sides_[side].sent() % kNumPlanes;
        if (const std::optional<Bytes> probe = sides_[side].NextProbe(now_us_)) Say(side, plane, *probe, lost);
        sides_[side].Tick(now_us_);
      }
      if (sides_[0].finished() && sides_[1].finished()) return true;
    }
    return false;
  }

  static bool IsProbe(const Bytes& datagram) { return datagram.size() == PeerSession::kProbeBytes; }

  std::array<PeerSession, 2> sides_{PeerSession(11, 1000), PeerSession(22, 1000)};
  int64_t now_us_ = 1'000'000;
};

TEST_F(PeerSessionTest, NothingLostIsNothingLost) {
  ASSERT_TRUE(Run([](int, const Bytes&) { return false; }));
  const PeerResult result = sides_[0].Result();
  EXPECT_EQ(result.lost_to_peer(), 0);
  EXPECT_EQ(result.lost_from_peer(), 0);
  EXPECT_EQ(result.round_trips_us.size(), 1000u);
  EXPECT_EQ(result.round_trip_us(0.5), 2 * kTripUs);
  EXPECT_EQ(result.clock_offset_us, kPeerClockAheadUs);
}

TEST_F(PeerSessionTest, CountsEachDirectionByItself) {
  std::mt19937 random(1);
  int dropped[2] = {0, 0};
  ASSERT_TRUE(Run([&](int from, const Bytes& datagram) {
    const bool lost = random() % 100 < (from == 0 ? 5u : 30u);
    if (lost && IsProbe(datagram)) ++dropped[from];
    return lost;
  }));
  for (int side = 0; side < 2; ++side) {
    EXPECT_NEAR(sides_[side].Result().lost_to_peer(), dropped[side] / 1000.0, 1e-12);
    EXPECT_NEAR(sides_[side].Result().lost_from_peer(), dropped[1 - side] / 1000.0, 1e-12);
  }
  EXPECT_GT(dropped[1], 4 * dropped[0]);
  EXPECT_LT(sides_[0].Result().round_trips_us.size(), 1000u - static_cast<size_t>(dropped[0]));
}

TEST_F(PeerSessionTest, RepeatedProbesCountOnce) {
  ASSERT_TRUE(Run([&](int from, const Bytes& datagram) {
    if (from == 0 && IsProbe(datagram)) sides_[1].Handle(datagram, 0, now_us_, now_us_);
    return false;
  }));
  EXPECT_EQ(sides_[1].Result().lost_from_peer(), 0);
}

TEST_F(PeerSessionTest, DoesNotPairWithWhoCannotHearIt) {
  EXPECT_FALSE(Run([](int from, const Bytes&) { return from == 0; }));
  EXPECT_TRUE(sides_[0].heard());
  EXPECT_FALSE(sides_[0].paired());
  EXPECT_FALSE(sides_[1].heard());
  EXPECT_EQ(sides_[0].sent(), 0);
}

TEST_F(PeerSessionTest, ThirdHostsAndGarbageChangeNothing) {
  PeerSession third(33, 5);
  third.Handle(sides_[0].State(), 0, now_us_, now_us_);
  ASSERT_TRUE(third.heard());
  const auto disturb = [&](int from, const Bytes& datagram) {
    Bytes cut(datagram.begin(), datagram.begin() + static_cast<long>(datagram.size() % 61));
    sides_[from].Handle(cut, 0, now_us_, now_us_);
    sides_[from].Handle(third.State(), 0, now_us_, now_us_);
    return false;
  };
  // The first to be heard is the peer; who comes later is passed over.
  Say(1, 0, sides_[1].State(), [](int, const Bytes&) { return false; });
  ASSERT_TRUE(Run(disturb));
  EXPECT_EQ(sides_[0].peer_probes(), 1000);
  EXPECT_EQ(sides_[0].Result().lost_from_peer(), 0);
}

}  // namespace
}  // namespace cairn::deploy
