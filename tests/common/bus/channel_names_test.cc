#include <gtest/gtest.h>

#include "common/bus/bus.h"

namespace cairn {
namespace {

// What lcm-spy's column shows.
constexpr size_t kReadable = 20;

TEST(ChannelNamesTest, FitTheColumnOfLcmSpy) {
  for (const std::string name :
       {kControlChannel, kWelcomeChannel, kStateChannel, kPolicyChannel, kHelloChannel, kStatusChannel,
        kTableRequestChannel, kTableInfoChannel, kTableChunkChannel, kLearnerChannel, kPlannerChannel}) {
    EXPECT_LE(name.size(), kReadable) << name;
  }
  EXPECT_LE(ExperienceChannel(65535).size(), kReadable);
  EXPECT_LE(ActorChannel(65535).size(), kReadable);
}

TEST(ChannelNamesTest, IdsOfOneWidthSortAsNumbers) {
  EXPECT_EQ(ActorChannel(3), "CAIRN_ACTOR_0003");
  EXPECT_LT(ActorChannel(99), ActorChannel(1000));
  EXPECT_LT(ExperienceChannel(2), ExperienceChannel(10));
}

}  // namespace
}  // namespace cairn
