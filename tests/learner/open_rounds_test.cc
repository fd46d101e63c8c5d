#include "learner/open_rounds.h"

#include <gtest/gtest.h>

namespace cairn::learner {
namespace {

Segment MakeSegment(int vehicle, int steps, int64_t version, int episode = 0) {
  Segment s;
  s.vehicle = vehicle;
  s.episode = episode;
  s.policy_version = version;
  s.rewards.assign(static_cast<size_t>(steps), 0.0f);
  return s;
}

TEST(OpenRoundsTest, IsCompleteWhenEveryVehicleHasItsStepsAndTheFirstOnesTheirExtra) {
  OpenRounds rounds(2);
  EXPECT_FALSE(rounds.front_complete());
  rounds.Grant(3, 1, 5, false);
  EXPECT_EQ(rounds.missing(), 7);
  EXPECT_TRUE(rounds.Add(MakeSegment(1, 3, 5), 0));
  EXPECT_TRUE(rounds.Add(MakeSegment(0, 3, 5), 0));
  EXPECT_FALSE(rounds.front_complete());
  EXPECT_TRUE(rounds.Add(MakeSegment(0, 1, 5), 3));
  EXPECT_TRUE(rounds.front_complete());
}

TEST(OpenRoundsTest, RefusesWhatGoesBeyondTheRoundOrHasAnotherPolicy) {
  OpenRounds rounds(1);
  rounds.Grant(3, 0, 5, false);
  EXPECT_FALSE(rounds.Add(MakeSegment(0, 4, 5), 0));
  EXPECT_FALSE(rounds.Add(MakeSegment(0, 3, 4), 0));
  EXPECT_TRUE(rounds.Add(MakeSegment(0, 3, 5), 0));
  EXPECT_FALSE(rounds.Add(MakeSegment(0, 1, 5), 3)) << "nothing more is granted";
  rounds.Grant(3, 0, 6, false);
  EXPECT_FALSE(rounds.Add(MakeSegment(0, 4, 5), 2)) << "spans two rounds";
}

TEST(OpenRoundsTest, TakesRoundsInOrderSortedByVehicleWhateverTheOrderOfArrival) {
  OpenRounds rounds(3);
  rounds.Grant(2, 0, 5, true);
  rounds.Grant(1, 0, 6, false);
  EpisodeResult episode;
  episode.vehicle = 2;
  rounds.Add(episode, 2);  // of the second round
  for (const int v : {2, 0}) {
    EXPECT_TRUE(rounds.Add(MakeSegment(v, 1, 5, 0), 0));
    EXPECT_TRUE(rounds.Add(MakeSegment(v, 1, 5, 1), 1));
    EXPECT_TRUE(rounds.Add(MakeSegment(v, 1, 6), 2));
  }
  EXPECT_FALSE(rounds.front_complete());
  EXPECT_TRUE(rounds.Add(MakeSegment(1, 2, 5), 0));
  ASSERT_TRUE(rounds.front_complete());
  const Harvest first = rounds.TakeFront();
  ASSERT_EQ(first.segments.size(), 5u);
  EXPECT_TRUE(first.episodes.empty());
  const int vehicles[] = {0, 0, 1, 2, 2};
  const int episodes[] = {0, 1, 0, 0, 1};
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(first.segments[i].vehicle, vehicles[i]);
    EXPECT_EQ(first.segments[i].episode, episodes[i]);
  }
  EXPECT_FALSE(rounds.front_complete());
  ASSERT_EQ(rounds.granted().size(), 1u);
  EXPECT_EQ(rounds.granted()[0].round, 2);
  EXPECT_EQ(rounds.granted()[0].vehicle_steps, 3);
  EXPECT_TRUE(rounds.Add(MakeSegment(1, 1, 6), 2));
  EXPECT_EQ(rounds.TakeFront().episodes.size(), 1u);
}

TEST(OpenRoundsTest, GoesOnAfterARaggedEndByLevellingFirst) {
  OpenRounds rounds(3);
  rounds.Restore(7, {11, 11, 10});
  EXPECT_FALSE(rounds.level());
  EXPECT_EQ(rounds.Grant(1, 0, 5, false), 1);
  EXPECT_TRUE(rounds.level());
  EXPECT_TRUE(rounds.Add(MakeSegment(2, 1, 5), 10));
  ASSERT_TRUE(rounds.front_complete());
  EXPECT_EQ(rounds.TakeFront().segments.size(), 1u);
  EXPECT_EQ(rounds.taken(), 8);
  EXPECT_EQ(rounds.Grant(4, 2, 6, false), 14);
}

TEST(OpenRoundsTest, KeepsTheBooksOfAVehicleAsTheyWereAtTheEndOfARoundThatAsksForThem) {
  OpenRounds rounds(1);
  rounds.Grant(2, 0, 5, false, true);
  rounds.Grant(2, 0, 6, false);
  VehicleState state;
  for (state.steps = 1; state.steps <= 3; ++state.steps) {
    EXPECT_TRUE(rounds.Add(MakeSegment(0, 1, state.steps <= 2 ? 5 : 6), state.steps - 1));
    state.next_step = 10 + static_cast<int32_t>(state.steps);
    rounds.Passed(0, state);
  }
  const Harvest first = rounds.TakeFront();
  ASSERT_EQ(first.vehicles.size(), 1u);
  EXPECT_EQ(first.vehicles[0].next_step, 12);
}

TEST(OpenRoundsTest, WhatWasSplitToFitMessagesBecomesOneSegment) {
  const auto piece = [](int episode, int first_step, std::vector<float> observations, SegmentEnd end) {
    Segment s;
    s.episode = episode;
    s.first_step = first_step;
    s.end = end;
    s.actions.assign(2 * (observations.size() - 1), static_cast<float>(first_step));
    s.rewards.assign(observations.size() - 1, static_cast<float>(first_step));
    s.observations = std::move(observations);
    return s;
  };
  OpenRounds rounds(1);
  rounds.Grant(6, 0, 0, false);
  EXPECT_TRUE(rounds.Add(piece(0, 4, {1, 2, 3}, SegmentEnd::kNone), 0));
  EXPECT_TRUE(rounds.Add(piece(0, 6, {3, 4}, SegmentEnd::kTruncated), 2));
  EXPECT_TRUE(rounds.Add(piece(1, 0, {7, 8}, SegmentEnd::kNone), 3));
  EXPECT_TRUE(rounds.Add(piece(1, 1, {8, 9}, SegmentEnd::kNone), 4));
  EXPECT_TRUE(rounds.Add(piece(1, 2, {9, 5}, SegmentEnd::kNone), 5));
  const Harvest harvest = rounds.TakeFront();
  ASSERT_EQ(harvest.segments.size(), 2u);
  EXPECT_EQ(harvest.segments[0].observations, (std::vector<float>{1, 2, 3, 4}));
  EXPECT_EQ(harvest.segments[0].rewards, (std::vector<float>{4, 4, 6}));
  EXPECT_EQ(harvest.segments[0].actions.size(), 6u);
  EXPECT_EQ(harvest.segments[0].end, SegmentEnd::kTruncated);
  EXPECT_EQ(harvest.segments[1].observations, (std::vector<float>{7, 8, 9, 5}));
  EXPECT_EQ(harvest.segments[1].first_step, 0);
}

}  // namespace
}  // namespace cairn::learner
