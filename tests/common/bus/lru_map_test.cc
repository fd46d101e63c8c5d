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

}  // namespace
}  // namespace cairn
