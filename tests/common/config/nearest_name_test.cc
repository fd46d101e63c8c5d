#include "common/config/nearest_name.h"

#include <gtest/gtest.h>

namespace cairn {
namespace {

TEST(NearestNameTest, CountsEdits) {
  EXPECT_EQ(EditDistance("", "abc"), 3);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3);
  EXPECT_EQ(EditDistance("gamma", "Gamma"), 0);
}

TEST(NearestNameTest, PicksTheNearestAndTheFirstOfEquals) {
  EXPECT_EQ(NearestName("batchsize", {"buffer_size", "batch_size", "gamma"}), "batch_size");
  EXPECT_EQ(NearestName("x", {"a", "b"}), "a");
  EXPECT_EQ(NearestName("x", {}), "");
}

}  // namespace
}  // namespace cairn
