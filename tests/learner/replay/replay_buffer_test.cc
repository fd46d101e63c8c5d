#include "learner/replay/replay_buffer.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace cairn::learner {
namespace {

constexpr int kObservation = 3;
constexpr int kAction = 2;
constexpr double kGamma = 0.9;

/// Observation t is {t, t + 0.1, t + 0.2}, action t is {10 + t, 20 + t}, reward t is t + 1, t counted from `first`.
Segment MakeSegment(int steps, SegmentEnd end, int first = 0) {
  Segment segment;
  segment.end = end;
  segment.first_step = first;
  for (int t = first; t <= first + steps; ++t) {
    for (int i = 0; i < kObservation; ++i) segment.observations.push_back(static_cast<float>(t) + 0.1f * i);
    if (t == first + steps) break;
    segment.actions.push_back(10.0f + static_cast<float>(t));
    segment.actions.push_back(20.0f + static_cast<float>(t));
    segment.rewards.push_back(static_cast<float>(t + 1));
  }
  return segment;
}

float Observation(const ReplayBuffer& replay, int row) { return replay.row(row)[0]; }
float Reward(const ReplayBuffer& replay, int row) { return replay.row(row)[replay.reward_offset()]; }
float Discount(const ReplayBuffer& replay, int row) { return replay.row(row)[replay.discount_offset()]; }
float NextObservation(const ReplayBuffer& replay, int row) { return replay.row(row)[replay.next_observation_offset()]; }

TEST(ReplayBufferTest, StoresWholeTransitions) {
  ReplayBuffer replay(10, kObservation, kAction, 1, kGamma);
  EXPECT_EQ(replay.Insert(MakeSegment(2, SegmentEnd::kNone)), 2);
  EXPECT_EQ(replay.size(), 2);
  const float* row = replay.row(1);
  const std::vector<float> expected{1.0f, 1.1f, 1.2f, 11.0f, 21.0f, 2.0f, 0.9f, 2.0f, 2.1f, 2.2f};
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_FLOAT_EQ(row[i], expected[i]) << i;
}

TEST(ReplayBufferTest, RowsAreAlignedToCacheLines) {
  ReplayBuffer replay(4, 14, 3, 1, kGamma);
  EXPECT_EQ(replay.row_floats(), 48);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(reinterpret_cast<uintptr_t>(replay.row(i)) % 64, 0u);
}

TEST(ReplayBufferTest, QuadrotorRowsFitTheirMemory) {
  ReplayBuffer replay(500000, 27, 3, 3, kGamma);
  EXPECT_LE(static_cast<double>(replay.capacity()) * replay.row_floats() * sizeof(float), 150e6);
}

TEST(ReplayBufferTest, SumsNStepsAndShortensAtTheEnd) {
  ReplayBuffer replay(10, kObservation, kAction, 3, kGamma);
  replay.Insert(MakeSegment(4, SegmentEnd::kNone));
  EXPECT_FLOAT_EQ(Reward(replay, 0), 1 + 0.9 * 2 + 0.81 * 3);
  EXPECT_FLOAT_EQ(Discount(replay, 0), 0.729);
  EXPECT_FLOAT_EQ(NextObservation(replay, 0), 3);
  EXPECT_FLOAT_EQ(Reward(replay, 2), 3 + 0.9 * 4);
  EXPECT_FLOAT_EQ(Discount(replay, 2), 0.81);
  EXPECT_FLOAT_EQ(NextObservation(replay, 2), 4);
  EXPECT_FLOAT_EQ(Reward(replay, 3), 4);
  EXPECT_FLOAT_EQ(Discount(replay, 3), 0.9);
  EXPECT_FLOAT_EQ(NextObservation(replay, 3), 4);
}

TEST(ReplayBufferTest, NoBootstrapWithinReachOfATerminatedEnd) {
  ReplayBuffer replay(10, kObservation, kAction, 3, kGamma);
  replay.Insert(MakeSegment(5, SegmentEnd::kTerminated));
  EXPECT_FLOAT_EQ(Discount(replay, 0), 0.729);
  EXPECT_FLOAT_EQ(Discount(replay, 1), 0.729);
  for (int row : {2, 3, 4}) EXPECT_EQ(Discount(replay, row), 0.0f) << row;
  EXPECT_FLOAT_EQ(Reward(replay, 2), 3 + 0.9 * 4 + 0.81 * 5);
}

TEST(ReplayBufferTest, KeepsBootstrapOnTruncatedAndCutEnds) {
  for (SegmentEnd end : {SegmentEnd::kTruncated, SegmentEnd::kCut}) {
    ReplayBuffer replay(10, kObservation, kAction, 3, kGamma);
    replay.Insert(MakeSegment(2, end));
    EXPECT_FLOAT_EQ(Discount(replay, 0), 0.81);
    EXPECT_FLOAT_EQ(Discount(replay, 1), 0.9);
    EXPECT_FLOAT_EQ(NextObservation(replay, 1), 2);
  }
}

TEST(ReplayBufferTest, OverwritesOldestWhenFull) {
  ReplayBuffer replay(5, kObservation, kAction, 1, kGamma);
  replay.Insert(MakeSegment(4, SegmentEnd::kNone));
  replay.Insert(MakeSegment(3, SegmentEnd::kNone, 4));
  EXPECT_EQ(replay.size(), 5);
  EXPECT_EQ(replay.num_inserted(), 7);
  EXPECT_FLOAT_EQ(Observation(replay, 0), 5);
  EXPECT_FLOAT_EQ(Observation(replay, 1), 6);
  EXPECT_FLOAT_EQ(Observation(replay, 2), 2);
  EXPECT_FLOAT_EQ(Observation(replay, 4), 4);
}

TEST(ReplayBufferTest, SegmentLongerThanTheRingLeavesItsTail) {
  ReplayBuffer replay(3, kObservation, kAction, 2, kGamma);
  EXPECT_EQ(replay.Insert(MakeSegment(8, SegmentEnd::kTerminated)), 8);
  EXPECT_EQ(replay.size(), 3);
  EXPECT_FLOAT_EQ(Observation(replay, 1), 7);
  EXPECT_EQ(Discount(replay, 1), 0.0f);
}

TEST(ReplayBufferTest, EmptySegmentAddsNothing) {
  ReplayBuffer replay(3, kObservation, kAction, 2, kGamma);
  EXPECT_EQ(replay.Insert(MakeSegment(0, SegmentEnd::kTruncated)), 0);
  EXPECT_EQ(replay.size(), 0);
}

}  // namespace
}  // namespace cairn::learner
