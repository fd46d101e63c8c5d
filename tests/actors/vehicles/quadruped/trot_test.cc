#include "actors/vehicles/quadruped/trot.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cairn::actors {
namespace {

TrotParams Params() {
  TrotParams params;
  params.hip_x = {0.04, 0.04, -0.04, -0.04};
  params.hip_y = {0.025, -0.025, 0.025, -0.025};
  return params;
}

constexpr double kStep = 0.15 / 100;  // a hundredth of a cycle

TEST(TrotTest, DiagonalFeetSwingTogetherHalfACycleEach) {
  Trot trot(Params());
  int left_front = 0;
  for (int i = 0; i < 1000; ++i) {
    trot.Advance(kStep, {0.2, 0, 0}, {0.2, 0, 0});
    EXPECT_EQ(trot.Swings(0), trot.Swings(3));
    EXPECT_EQ(trot.Swings(1), trot.Swings(2));
    EXPECT_NE(trot.Swings(0), trot.Swings(1));
    left_front += trot.Swings(0);
  }
  EXPECT_NEAR(left_front, 500, 10);
}

// A standing foot moves at −v: from v T/4 ahead of its hip to as much behind it.
TEST(TrotTest, StandingFeetMoveAgainstTheVelocityAroundTheHip) {
  Trot trot(Params());
  const Trot::Velocity velocity{0.2, 0, 0};
  double front = 0, back = 0, lowest = 0, highest = -1;
  for (int i = 0; i < 500; ++i) {
    const double before = trot.state().feet[0].x;
    const bool stood = !trot.Swings(0);
    const FootPosition foot = trot.Advance(kStep, velocity, velocity)[0];
    if (i < 200) continue;
    if (stood && !trot.Swings(0)) {
      EXPECT_NEAR(foot.x, before - 0.2 * kStep, 1e-12);
      front = std::max(front, foot.x);
      back = std::min(back, foot.x);
    }
    lowest = std::min(lowest, foot.z);
    highest = std::max(highest, foot.z);
  }
  const double quarter = 0.2 * 0.15 / 4;
  EXPECT_NEAR(front, quarter, 0.1 * quarter);
  EXPECT_NEAR(back, -quarter, 0.1 * quarter);
  EXPECT_DOUBLE_EQ(lowest, -0.056);
  EXPECT_NEAR(highest, -0.056 + 0.015, 1e-4);
}

// Raibert: half a stance of the excess, and the gain times it, further out.
TEST(TrotTest, LandsFurtherOutWhenTooFast) {
  Trot trot(Params()), slow(Params());
  for (Trot* t : {&trot, &slow}) {
    const Trot::Velocity measured{t == &trot ? 0.1 + 0.05 : 0.1, 0, 0};
    while (!t->Swings(0)) t->Advance(kStep, {0.1, 0, 0}, measured);
    while (t->Swings(0)) t->Advance(kStep, {0.1, 0, 0}, measured);
  }
  const double more = (0.5 * 0.075 + 0.03) * 0.05;
  EXPECT_NEAR(trot.state().feet[0].x - slow.state().feet[0].x, more, 0.02 * more);
}

TEST(TrotTest, TurningFeetMoveAlongCirclesAboutTheCentre) {
  Trot trot(Params());
  for (int i = 0; i < 10; ++i) trot.Advance(kStep, {0, 0, 1}, {0, 0, 1});
  const Trot::Foot& foot = trot.state().feet[0];  // stands in the first half
  EXPECT_NEAR(foot.x, 10 * kStep * 0.025, 1e-5);
  EXPECT_NEAR(foot.y, -10 * kStep * 0.04, 1e-5);
  EXPECT_NEAR(std::hypot(0.04 + foot.x, 0.025 + foot.y), std::hypot(0.04, 0.025), 1e-5);
}

TEST(TrotTest, RestsAtTheNextChangeOfPairs) {
  Trot trot(Params());
  for (int i = 0; i < 130; ++i) trot.Advance(kStep, {0.2, 0, 0}, {0.2, 0, 0});
  std::array<FootPosition, 4> feet{};
  for (int i = 0; i < 100; ++i) feet = trot.Advance(kStep, {}, {});
  EXPECT_DOUBLE_EQ(trot.phase(), 0.5);
  for (const FootPosition& foot : feet) EXPECT_DOUBLE_EQ(foot.z, -0.056);
}

}  // namespace
}  // namespace cairn::actors
