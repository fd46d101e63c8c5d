#include "common/bus/replay_window.h"

#include <gtest/gtest.h>

#include <set>

#include "common/core/random.h"

namespace cairn {
namespace {

constexpr uint64_t kSize = ReplayWindow::kSize;

TEST(ReplayWindowTest, AcceptsEachCounterOnceInAnyOrder) {
  ReplayWindow window;
  for (const uint64_t counter : {5, 3, 4, 1, 2}) EXPECT_TRUE(window.Accept(counter)) << counter;
  for (const uint64_t counter : {1, 2, 3, 4, 5}) EXPECT_FALSE(window.Accept(counter)) << counter;
}

TEST(ReplayWindowTest, RefusesWhatIsTooOld) {
  ReplayWindow window;
  EXPECT_TRUE(window.Accept(10 * kSize));
  EXPECT_TRUE(window.Accept(9 * kSize + 1)) << "the oldest inside";
  EXPECT_FALSE(window.Accept(9 * kSize));
  EXPECT_FALSE(window.Accept(1));
}

TEST(ReplayWindowTest, FarJumpForgetsNothingThatMatters) {
  ReplayWindow window;
  for (uint64_t counter = 1; counter <= kSize; ++counter) EXPECT_TRUE(window.Accept(counter));
  EXPECT_TRUE(window.Accept(1'000'000));
  EXPECT_FALSE(window.Accept(1'000'000));
  EXPECT_FALSE(window.Accept(kSize));
  EXPECT_TRUE(window.Accept(1'000'000 - kSize + 1)) << "not the bit of a counter long ago";
  EXPECT_TRUE(window.Accept(UINT64_MAX));
  EXPECT_TRUE(window.Accept(UINT64_MAX - kSize + 1));
  EXPECT_FALSE(window.Accept(UINT64_MAX));
  EXPECT_FALSE(window.Accept(UINT64_MAX - kSize));
  EXPECT_FALSE(window.Accept(0));
}

// Against the definition, kept as a set of all counters.
TEST(ReplayWindowTest, AgreesWithItsDefinitionOnRandomCounters) {
  RandomStream random(1, RandomPurpose::kTest);
  ReplayWindow window;
  std::set<uint64_t> seen;
  uint64_t highest = 0, base = 2000;
  for (int i = 0; i < 200000; ++i) {
    base += random.Below(i % 1000 == 0 ? 5000 : 3);
    const uint64_t counter = base - random.Below(1500);
    const bool expected = seen.count(counter) == 0 && counter + kSize > highest;
    ASSERT_EQ(window.Accept(counter), expected) << counter << " after " << highest;
    if (expected) seen.insert(counter);
    highest = std::max(highest, counter);
  }
}

TEST(ReplayGuardTest, PlanesAndSessionsHaveWindowsOfTheirOwn) {
  ReplayGuard guard;
  EXPECT_TRUE(guard.Accept(Plane::kControl, 1, 5));
  EXPECT_TRUE(guard.Accept(Plane::kTables, 1, 5));
  EXPECT_TRUE(guard.Accept(Plane::kControl, 2, 5));
  EXPECT_FALSE(guard.Accept(Plane::kControl, 1, 5));
  EXPECT_FALSE(guard.Accept(Plane::kTables, 1, 5));
  EXPECT_EQ(guard.size(), 3u);
}

TEST(ReplayGuardTest, ForgetsTheSessionThatWasSilentLongest) {
  ReplayGuard guard(2);
  EXPECT_TRUE(guard.Accept(Plane::kControl, 1, 1));
  EXPECT_TRUE(guard.Accept(Plane::kControl, 2, 1));
  EXPECT_TRUE(guard.Accept(Plane::kControl, 1, 2));
  EXPECT_TRUE(guard.Accept(Plane::kControl, 3, 1));  // 2 goes
  EXPECT_EQ(guard.size(), 2u);
  EXPECT_FALSE(guard.Accept(Plane::kControl, 1, 1));
  EXPECT_FALSE(guard.Accept(Plane::kControl, 3, 1));
}

}  // namespace
}  // namespace cairn
