#include "common/bus/lru_map.h"

#include <gtest/gtest.h>

namespace cairn {
namespace {

TEST(LruMapTest, FindsWhatWasInserted) {
  LruMap<int, int> map(2);
  EXPECT_EQ(map.Find(1), nullptr);
  EXPECT_EQ(*map.Insert(1, 10), 10);
  EXPECT_EQ(*map.Find(1), 10);
  *map.Find(1) = 11;
  EXPECT_EQ(*map.Find(1), 11);
}

TEST(LruMapTest, ForgetsTheKeyUsedLongestAgo) {
  LruMap<int, int> map(2);
  map.Insert(1, 10);
  map.Insert(2, 20);
  map.Find(1);
  map.Insert(3, 30);
  EXPECT_EQ(map.size(), 2u);
  EXPECT_EQ(map.Find(2), nullptr);
  EXPECT_EQ(*map.Find(1), 10);
  EXPECT_EQ(*map.Find(3), 30);
}

TEST(LruMapTest, KeepsWithinTheWeightButForTheNewest) {
  LruMap<int, int> map(10);
  map.Insert(1, 10, 4);
  map.Insert(2, 20, 4);
  EXPECT_EQ(map.total_weight(), 8u);
  map.Insert(3, 30, 6);
  EXPECT_EQ(map.total_weight(), 10u);
  EXPECT_EQ(map.Find(1), nullptr);
  EXPECT_NE(map.Find(2), nullptr);
  map.Insert(4, 40, 99);
  EXPECT_EQ(map.size(), 1u);
  EXPECT_EQ(*map.Find(4), 40);
}

}  // namespace
}  // namespace cairn
