#include "actors/marks.h"

#include <gtest/gtest.h>

namespace cairn::actors {
namespace {

const Vector3d kDoor(1, 2, 0);

TEST(MarksTest, WhatIsSeenNearAMarkConfirmsIt) {
  Marks marks(0.02, 8);
  EXPECT_TRUE(marks.Add(kDoor, 0));
  EXPECT_FALSE(marks.Add(kDoor + Vector3d(0.015, 0, 0), 1));
  EXPECT_TRUE(marks.Add(kDoor + Vector3d(0.03, 0, 0), 1));
  EXPECT_EQ(marks.places().size(), 2u);
  EXPECT_EQ(marks.places().front(), kDoor);
}

TEST(MarksTest, APasserByIsForgottenAfterALifetime) {
  Marks marks(0.02, 8);
  marks.Add(kDoor, 0);
  marks.Add(kDoor, 3);
  EXPECT_FALSE(marks.Forget(11));
  EXPECT_EQ(marks.places().size(), 1u);
  EXPECT_TRUE(marks.Forget(11.1));
  EXPECT_TRUE(marks.places().empty());
  EXPECT_FALSE(marks.Forget(12));
}

TEST(MarksTest, APlaceThatIsFoundBlockedAgainIsBelievedTwiceAsLong) {
  Marks marks(0.02, 8);
  double time = 0;
  for (const double lifetime : {8, 16, 32}) {
    EXPECT_TRUE(marks.Add(kDoor, time));
    time += 2;
    EXPECT_FALSE(marks.Add(kDoor, time)) << "seen to stand for two seconds";
    EXPECT_FALSE(marks.Forget(time + lifetime));
    time += lifetime + 1;
    EXPECT_TRUE(marks.Forget(time));
  }
}

TEST(MarksTest, ButNotTwiceAsLongAfterSomebodyOnlyPassedAgain) {
  Marks marks(0.02, 8);
  for (double time = 0; time < 100; time += 20) {
    EXPECT_TRUE(marks.Add(kDoor, time));
    EXPECT_FALSE(marks.Add(kDoor, time + 1));
    EXPECT_FALSE(marks.Forget(time + 9));
    EXPECT_TRUE(marks.Forget(time + 9.1));
  }
}

TEST(MarksTest, WhatWasSeenFreeBeginsAnew) {
  Marks marks(0.02, 8);
  marks.Add(kDoor, 0);
  marks.Forget(9);
  marks.Add(kDoor, 10);
  EXPECT_TRUE(marks.Remove(kDoor));
  EXPECT_FALSE(marks.Remove(kDoor));
  EXPECT_TRUE(marks.Add(kDoor, 20));
  EXPECT_TRUE(marks.Forget(28.1)) << "eight seconds again";
}

TEST(MarksTest, MemoryEnds) {
  Marks marks(0.02, 1);
  marks.Add(kDoor, 0);
  marks.Forget(2);
  EXPECT_FALSE(marks.empty());
  marks.Forget(17);
  EXPECT_TRUE(marks.empty());
}

}  // namespace
}  // namespace cairn::actors
