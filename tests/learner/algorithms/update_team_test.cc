#include "learner/algorithms/update_team.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <thread>

namespace cairn::learner {
namespace {

TEST(UpdateTeamTest, EachMemberRunsOncePerCall) {
  UpdateTeam team(4);
  std::array<int, 4> calls{};
  for (int i = 0; i < 1000; ++i) team.Run([&](int member) { ++calls[member]; });
  EXPECT_THAT(calls, testing::Each(1000));
}

TEST(UpdateTeamTest, TheFirstIsTheCallersThread) {
  UpdateTeam team(2);
  std::array<std::thread::id, 2> ids;
  team.Run([&](int member) { ids[member] = std::this_thread::get_id(); });
  EXPECT_EQ(ids[0], std::this_thread::get_id());
  EXPECT_NE(ids[1], std::this_thread::get_id());
}

TEST(UpdateTeamTest, EndsWithoutHavingRun) { UpdateTeam team(3); }

struct Seen {
  std::vector<int> firsts;
  int starts = 0;
};

TEST(ForChunksTest, MembersShareTheChunksInOrder) {
  const Chunks chunks(1000, 64);
  for (int threads : {1, 2, 3}) {
    UpdateTeam team(threads);
    std::vector<Seen> seen(threads);
    BatchFeeder feeder;
    ForChunks(&team, chunks, &feeder, &seen, [](int first, int, Accumulate accumulate, BatchFeeder*, Seen* member) {
      member->firsts.push_back(first);
      member->starts += accumulate == Accumulate::kOverwrite ? 1 : 0;
    });
    std::vector<int> all;
    for (const Seen& member : seen) {
      EXPECT_EQ(member.starts, 1);
      all.insert(all.end(), member.firsts.begin(), member.firsts.end());
    }
    ASSERT_EQ(static_cast<int>(all.size()), chunks.count());
    for (int c = 0; c < chunks.count(); ++c) EXPECT_EQ(all[c], chunks.first(c));
  }
}

}  // namespace
}  // namespace cairn::learner
