#include "learner/algorithms/update_team.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <barrier>
#include <iterator>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

namespace cairn::learner {
namespace {

TEST(UpdateTeamTest, EachShareRunsOncePerCall) {
  UpdateTeam team(4);
  std::array<int, 4> calls{};
  for (int i = 0; i < 1000; ++i) team.Run([&](int share) { ++calls[share]; });
  EXPECT_THAT(calls, testing::Each(1000));
}

TEST(UpdateTeamTest, SharesRunAtOnce) {
  UpdateTeam team(3);
  std::barrier all_here(3);
  std::array<std::thread::id, 3> ids;
  team.Run([&](int share) {
    all_here.arrive_and_wait();
    ids[share] = std::this_thread::get_id();
  });
  EXPECT_EQ(ids[0], std::this_thread::get_id());
  EXPECT_EQ((std::set<std::thread::id>(ids.begin(), ids.end()).size()), 3u);
}

TEST(UpdateTeamTest, EndsWithoutHavingRun) { UpdateTeam team(3); }

struct Seen {
  std::vector<int> firsts;
  int starts = 0;
};

/// Writes down which chunks members asked for, by their first sample.
class RecordingFeeder final : public BatchFeeder {
 public:
  void Expect(int first, int /*count*/, bool of_next_batch) override {
    const std::lock_guard lock(mutex_);
    (of_next_batch ? expected_next : expected).push_back(first);
  }
  void Need(int first, int /*count*/) override {
    const std::lock_guard lock(mutex_);
    needed.push_back(first);
  }

  std::vector<int> needed, expected, expected_next;

 private:
  std::mutex mutex_;
};

TEST(ForChunksTest, MembersShareTheChunksInOrder) {
  for (int threads : {1, 2, 3}) {
    const Chunks chunks(1000, 64, threads, 5000);
    UpdateTeam team(threads);
    std::vector<Seen> seen(threads);
    BatchFeeder feeder;
    ForChunks(&team, chunks, &feeder, &seen, [](int first, int, Accumulate accumulate, Seen* member) {
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

TEST(ForChunksTest, TheCallerTakesWhatItComputesWhileTheOthersWakeUp) {
  const auto callers = [](int batch_size, int width, int threads, size_t parameters) {
    const Chunks chunks(batch_size, width, threads, parameters);
    return std::pair(chunks.share_begin(1), chunks.count());
  };
  EXPECT_EQ(callers(1024, 64, 1, 5377), std::pair(8, 8));
  EXPECT_EQ(callers(1024, 64, 2, 5377), std::pair(9, 16));
  EXPECT_EQ(callers(256, 64, 2, 5377), std::pair(3, 4));
  EXPECT_EQ(callers(256, 256, 2, 70657), std::pair(4, 8));  // a chunk takes longer than waking up
  EXPECT_EQ(callers(64, 64, 2, 5377), std::pair(1, 1));     // too little to share
}

TEST(ForChunksTest, AsksForEveryChunkOnceAndAnnouncesTheFollowingOne) {
  for (int threads : {1, 2, 3}) {
    const Chunks chunks(1000, 64, threads, 5000);
    UpdateTeam team(threads);
    std::vector<Seen> seen(threads);
    RecordingFeeder feeder;
    ForChunks(&team, chunks, &feeder, &seen, [](int, int, Accumulate, Seen*) {});
    std::vector<int> all, starts, rest;
    for (int c = 0; c < chunks.count(); ++c) all.push_back(chunks.first(c));
    for (int t = 0; t < threads; ++t) starts.push_back(chunks.first(chunks.share_begin(t)));
    std::set_difference(all.begin(), all.end(), starts.begin(), starts.end(), std::back_inserter(rest));
    EXPECT_THAT(feeder.needed, testing::UnorderedElementsAreArray(all));
    EXPECT_THAT(feeder.expected, testing::UnorderedElementsAreArray(rest));
    EXPECT_THAT(feeder.expected_next, testing::UnorderedElementsAreArray(starts));
  }
}

}  // namespace
}  // namespace cairn::learner
