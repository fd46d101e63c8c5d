#include "actors/experience_batcher.h"

#include <gtest/gtest.h>

#include "common/bus/codec.h"
#include "common/core/check.h"

namespace cairn::actors {
namespace {

constexpr int kObservation = 5;
constexpr int kAction = 2;

Segment MakeSegment(int vehicle, int steps, SegmentEnd end) {
  Segment s;
  s.vehicle = vehicle;
  s.episode = 3;
  s.first_step = 7;
  s.end = end;
  s.table_hash = 11;
  s.policy_incarnation = 12;
  s.policy_version = 13;
  float next = static_cast<float>(1000 * vehicle);
  for (int i = 0; i < (steps + 1) * kObservation; ++i) s.observations.push_back(next++);
  for (int i = 0; i < steps * kAction; ++i) s.actions.push_back(next++);
  for (int i = 0; i < steps; ++i) s.rewards.push_back(next++);
  return s;
}

std::vector<Experience> Pack(std::vector<Segment> segments, int max_bytes, int num_episodes = 0) {
  return PackExperience(std::move(segments), std::vector<EpisodeResult>(static_cast<size_t>(num_episodes)), {},
                        kObservation, kAction, max_bytes);
}

TEST(ExperienceBatcherTest, NothingMakesNoMessage) { EXPECT_TRUE(Pack({}, 1000).empty()); }

TEST(ExperienceBatcherTest, FillsMessagesInOrderAndNeverBeyondTheirSize) {
  std::vector<Segment> segments;
  for (int v = 0; v < 40; ++v) segments.push_back(MakeSegment(v, 1 + v % 7, SegmentEnd::kNone));
  for (const int max_bytes : {400, 1400, 60000}) {
    const std::vector<Experience> messages = Pack(segments, max_bytes, 9);
    std::vector<int> steps(40, 0);
    int episodes = 0, last_vehicle = 0;
    for (const Experience& message : messages) {
      // The encoded header is counted in full; 8 bytes of fingerprint and 56 of fields.
      EXPECT_LE(Encode(message).size(), static_cast<size_t>(max_bytes));
      EXPECT_TRUE(message.episodes.empty() || last_vehicle == 0) << "results go first";
      episodes += static_cast<int>(message.episodes.size());
      for (const Segment& s : message.segments) {
        EXPECT_GE(s.vehicle, last_vehicle);
        last_vehicle = s.vehicle;
        steps[static_cast<size_t>(s.vehicle)] += s.num_steps();
      }
    }
    EXPECT_EQ(episodes, 9);
    for (int v = 0; v < 40; ++v) EXPECT_EQ(steps[static_cast<size_t>(v)], 1 + v % 7);
  }
  EXPECT_EQ(Pack(segments, 60000, 9).size(), 1u);
}

TEST(ExperienceBatcherTest, PiecesOfALongSegmentContinueEachOtherAndOnlyTheLastEndsIt) {
  const Segment whole = MakeSegment(2, 100, SegmentEnd::kTerminated);
  Segment joined;
  int next_step = whole.first_step;
  const std::vector<Experience> messages = Pack({whole}, 600);
  ASSERT_GT(messages.size(), 3u);
  for (size_t i = 0; i < messages.size(); ++i) {
    ASSERT_EQ(messages[i].segments.size(), 1u);
    const Segment& piece = messages[i].segments[0];
    EXPECT_EQ(piece.first_step, next_step);
    next_step += piece.num_steps();
    EXPECT_EQ(piece.end, i + 1 == messages.size() ? SegmentEnd::kTerminated : SegmentEnd::kNone);
    EXPECT_EQ(piece.policy_version, 13);
    EXPECT_EQ(piece.table_hash, 11u);
    EXPECT_EQ(messages[i].policy_incarnation, 12);
    if (i > 0) joined.observations.resize(joined.observations.size() - kObservation);  // the seam stands in both
    joined.observations.insert(joined.observations.end(), piece.observations.begin(), piece.observations.end());
    joined.actions.insert(joined.actions.end(), piece.actions.begin(), piece.actions.end());
    joined.rewards.insert(joined.rewards.end(), piece.rewards.begin(), piece.rewards.end());
  }
  EXPECT_EQ(joined.observations, whole.observations);
  EXPECT_EQ(joined.actions, whole.actions);
  EXPECT_EQ(joined.rewards, whole.rewards);
}

TEST(ExperienceBatcherTest, RefusesAnObservationThatFitsNoMessage) {
  EXPECT_THROW(PackExperience({MakeSegment(0, 1, SegmentEnd::kNone)}, {}, {}, kObservation, kAction, 120), UsageError);
}

}  // namespace
}  // namespace cairn::actors
