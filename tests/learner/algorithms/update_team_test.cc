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
  void Need(int first, int /*count*/) override {
    const std::lock_guard lock(mutex_);
    needed.push_back(first);
  }

  std::vector<int> needed;

 private:
  std::mutex mutex_;
};

/// The first samples of all chunks, share by share.
std::vector<int> Firsts(const Chunks& chunks) {
  std::vector<int> firsts;
  for (int share = 0; share < chunks.num_shares(); ++share) {
    for (const Chunk& chunk : chunks.share(share)) firsts.push_back(chunk.first);
  }
  return firsts;
}

TEST(ChunksTest, CoverTheBatchInOrder) {
  for (int batch_size : {1, 100, 255, 257, 1000, 1024, 5000}) {
    for (int shares : {1, 2, 3, 8}) {
      const Chunks chunks(batch_size, shares, 5000);
      EXPECT_LE(chunks.num_shares(), shares);
      int end = 0;
      for (int share = 0; share < chunks.num_shares(); ++share) {
        EXPECT_FALSE(chunks.share(share).empty());
        for (const Chunk& chunk : chunks.share(share)) {
          EXPECT_EQ(chunk.first, end);
          EXPECT_GT(chunk.size, 0);
          const std::vector<int> sizes = chunks.sizes();
          EXPECT_TRUE(std::binary_search(sizes.begin(), sizes.end(), chunk.size));
          end += chunk.size;
        }
      }
      EXPECT_EQ(end, batch_size);
    }
  }
}

TEST(ForChunksTest, MembersShareTheChunksInOrder) {
  for (int threads : {1, 2, 3}) {
    const Chunks chunks(1000, threads, 5000);
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
    EXPECT_EQ(all, Firsts(chunks));
  }
}

TEST(ChunksTest, TheCallerTakesWhatItComputesWhileTheOthersWakeUp) {
  const auto callers = [](int batch_size, int shares, size_t parameters) {
    int samples = 0;
    const Chunks chunks(batch_size, shares, parameters);
    for (const Chunk& chunk : chunks.share(0)) samples += chunk.size;
    return samples;
  };
  EXPECT_EQ(callers(1024, 1, 5377), 1024);
  EXPECT_EQ(callers(1024, 2, 5377), 544);
  EXPECT_EQ(callers(256, 2, 5377), 160);
  EXPECT_EQ(callers(256, 2, 70657), 132);  // waking up is worth few samples
  EXPECT_EQ(callers(64, 2, 5377), 64);     // too little to share
  EXPECT_EQ(Chunks(1024, 8, 5377).num_shares(), 8);
  EXPECT_EQ(Chunks(256, 8, 5377).num_shares(), 6) << "not all or none";
}

TEST(ForChunksTest, AsksForEveryChunkOnce) {
  for (int threads : {1, 2, 3}) {
    const Chunks chunks(1000, threads, 5000);
    UpdateTeam team(threads);
    std::vector<Seen> seen(threads);
    RecordingFeeder feeder;
    ForChunks(&team, chunks, &feeder, &seen, [](int, int, Accumulate, Seen*) {});
    EXPECT_THAT(feeder.needed, testing::UnorderedElementsAreArray(Firsts(chunks)));
  }
}

}  // namespace
}  // namespace cairn::learner
