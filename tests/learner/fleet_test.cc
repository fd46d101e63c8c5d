#include "learner/fleet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace cairn::learner {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr uint64_t kHash = 0xABCD;

Fleet MakeFleet(int actors = 2, int vehicles = 5) { return {actors, vehicles, kHash, 3, "rev"}; }

Hello MakeHello(int actor_id, int64_t session, int generation = 0) {
  Hello hello;
  hello.session = session;
  hello.experiment_hash = kHash;
  hello.actor_id = actor_id;
  hello.generation = generation;
  hello.observation_size = 3;
  hello.git_revision = "rev";
  return hello;
}

Segment MakeSegment(int vehicle, int episode, int first_step, int steps, SegmentEnd end = SegmentEnd::kNone) {
  Segment s;
  s.vehicle = vehicle;
  s.episode = episode;
  s.first_step = first_step;
  s.end = end;
  s.observations.assign(static_cast<size_t>(3 * (steps + 1)), 0.5f);
  s.actions.assign(static_cast<size_t>(2 * steps), 0.5f);
  s.rewards.assign(static_cast<size_t>(steps), 1.0f);
  return s;
}

// What the coordinator does with a segment.
Fleet::Verdict Take(Fleet* fleet, const ActorRecord& actor, const Segment& segment) {
  const Fleet::Verdict verdict = fleet->Judge(actor, segment);
  if (verdict == Fleet::Verdict::kSound) fleet->Accept(segment);
  return verdict;
}

const TimePoint kNow{std::chrono::hours(1)};

TEST(FleetTest, SplitsVehiclesContiguouslyOverTheActors) {
  Fleet fleet = MakeFleet(2, 5);
  EXPECT_THAT(fleet.Join(MakeHello(1, 11), kNow).vehicle, ElementsAre(2, 3, 4));
  EXPECT_FALSE(fleet.complete());
  EXPECT_THAT(fleet.Join(MakeHello(0, 10), kNow).vehicle, ElementsAre(0, 1));
  EXPECT_TRUE(fleet.complete());
}

TEST(FleetTest, EveryVehicleHasExactlyOneHome) {
  for (int actors = 1; actors <= 9; ++actors) {
    Fleet fleet = MakeFleet(actors, 8);
    std::vector<int> owners(8, 0);
    for (int a = 0; a < actors; ++a) {
      for (const int v : fleet.Join(MakeHello(a, 100 + a), kNow).vehicle) ++owners[static_cast<size_t>(v)];
    }
    EXPECT_THAT(owners, ::testing::Each(1)) << actors;
  }
}

TEST(FleetTest, RefusesAnotherRevisionOrExperimentNamingTheFields) {
  Fleet fleet = MakeFleet();
  Hello hello = MakeHello(0, 10);
  hello.git_revision = "other";
  hello.experiment_hash = 1;
  hello.observation_size = 4;
  const Welcome welcome = fleet.Join(hello, kNow);
  EXPECT_EQ(welcome.status, Welcome::Status::kRefused);
  EXPECT_THAT(welcome.reason, HasSubstr("git_revision is other (the learner's: rev)"));
  EXPECT_THAT(welcome.reason, HasSubstr("experiment_hash"));
  EXPECT_THAT(welcome.reason, HasSubstr("observation_size is 4"));
  EXPECT_EQ(fleet.Find(10), nullptr);
}

TEST(FleetTest, RefusesASecondHolderOfALivingIdOnly) {
  Fleet fleet = MakeFleet();
  fleet.Join(MakeHello(0, 10), kNow);
  EXPECT_EQ(fleet.Join(MakeHello(0, 11), kNow).status, Welcome::Status::kIdTaken);
  EXPECT_NE(fleet.Find(10), nullptr);
  // The supervisor's next generation replaces at once, a stranger when the holder has been silent.
  EXPECT_EQ(fleet.Join(MakeHello(0, 12, 1), kNow).status, Welcome::Status::kAccepted);
  EXPECT_EQ(fleet.Find(10), nullptr);
  EXPECT_EQ(fleet.Join(MakeHello(0, 13), kNow + std::chrono::minutes(1)).status, Welcome::Status::kAccepted);
}

TEST(FleetTest, RepeatedHelloOfOneSessionChangesNothing) {
  Fleet fleet = MakeFleet();
  const Welcome first = fleet.Join(MakeHello(0, 10), kNow);
  EXPECT_EQ(fleet.Join(MakeHello(0, 10), kNow).assignment, first.assignment);
}

TEST(FleetTest, OneActorsJoinLeavesTheAssignmentOfAnotherAlone) {
  Fleet fleet = MakeFleet();
  const int64_t assignment = fleet.Join(MakeHello(0, 10), kNow).assignment;
  fleet.Join(MakeHello(1, 20), kNow);
  EXPECT_EQ(fleet.Assignment(*fleet.Find(10)).assignment, assignment);
}

TEST(FleetTest, AcceptsTransitionsExactlyOnceAndInOrder) {
  Fleet fleet = MakeFleet();
  fleet.Join(MakeHello(0, 10), kNow);
  const ActorRecord& actor = *fleet.Find(10);
  using Verdict = Fleet::Verdict;
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(0, 0, 0, 4)), Verdict::kSound);
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(0, 0, 0, 4)), Verdict::kDuplicate);
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(0, 0, 6, 1)), Verdict::kGap);
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(0, 1, 0, 1)), Verdict::kGap) << "episode 0 goes on";
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(0, 0, 4, 2, SegmentEnd::kTerminated)), Verdict::kSound);
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(0, 0, 6, 1)), Verdict::kGap) << "episode 0 is over";
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(0, 2, 0, 1)), Verdict::kGap) << "episode 1 is missing";
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(0, 1, 0, 1)), Verdict::kSound);
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(0, 0, 4, 2)), Verdict::kDuplicate);
  EXPECT_EQ(fleet.vehicles()[0].steps, 7);
}

TEST(FleetTest, RefusesForeignVehiclesAndNonFiniteNumbers) {
  Fleet fleet = MakeFleet();
  fleet.Join(MakeHello(0, 10), kNow);
  const ActorRecord& actor = *fleet.Find(10);
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(4, 0, 0, 1)), Fleet::Verdict::kForeign);
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(-1, 0, 0, 1)), Fleet::Verdict::kForeign);
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(99, 0, 0, 1)), Fleet::Verdict::kForeign);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Segment s = MakeSegment(0, 0, 0, 2);
    s.observations[8] = bad;
    EXPECT_EQ(Take(&fleet, actor, s), Fleet::Verdict::kNotFinite);
    s = MakeSegment(0, 0, 0, 2);
    s.rewards[1] = bad;
    EXPECT_EQ(Take(&fleet, actor, s), Fleet::Verdict::kNotFinite);
  }
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(0, 0, 0, 2)), Fleet::Verdict::kSound);
}

TEST(FleetTest, ADivergedEpisodeIsOverWithoutALastSegment) {
  Fleet fleet = MakeFleet();
  fleet.Join(MakeHello(0, 10), kNow);
  const ActorRecord& actor = *fleet.Find(10);
  Take(&fleet, actor, MakeSegment(0, 0, 0, 4));
  EpisodeResult diverged;
  diverged.vehicle = 0;
  diverged.episode = 0;
  fleet.CloseDiverged(actor, diverged);
  EXPECT_EQ(Take(&fleet, actor, MakeSegment(0, 1, 0, 1)), Fleet::Verdict::kSound);
}

TEST(FleetTest, AReplacementGoesOnWhereTheAcceptedPrefixEnds) {
  Fleet fleet = MakeFleet();
  fleet.Join(MakeHello(0, 10), kNow);
  fleet.Join(MakeHello(1, 20), kNow);
  fleet.Start();
  Take(&fleet, *fleet.Find(10), MakeSegment(1, 0, 0, 4));
  EXPECT_FALSE(fleet.disturbed());
  const Welcome welcome = fleet.Join(MakeHello(0, 11, 1), kNow);
  EXPECT_TRUE(fleet.disturbed());
  EXPECT_THAT(welcome.vehicle, ElementsAre(0, 1));
  EXPECT_THAT(welcome.next_episode, ElementsAre(0, 1));
  EXPECT_THAT(welcome.steps_done, ElementsAre(0, 4));
  EXPECT_EQ(Take(&fleet, *fleet.Find(11), MakeSegment(1, 1, 0, 2)), Fleet::Verdict::kSound);
}

TEST(FleetTest, ReassignGivesTheVehiclesOfALostActorToTheOthers) {
  Fleet fleet = MakeFleet();
  fleet.Join(MakeHello(0, 10), kNow);
  fleet.Join(MakeHello(1, 20), kNow);
  EXPECT_THAT(fleet.Reassign(0), ElementsAre(20));
  EXPECT_THAT(fleet.Assignment(*fleet.Find(20)).vehicle, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_TRUE(fleet.Reassign(1).empty()) << "nobody could take over";
}

// The actor has acted on its newest assignment and has nothing on the way.
void Settle(Fleet* fleet, int64_t session) {
  ActorRecord* actor = fleet->Find(session);
  actor->status.assignment = actor->assignment;
  actor->status.last_sequence = actor->stream.received();
}

TEST(FleetTest, WhoeverJoinsLaterGetsAFairShareOnceTheOwnersHaveLetGo) {
  Fleet fleet = MakeFleet(2, 6);
  fleet.Join(MakeHello(0, 10), kNow);
  fleet.Join(MakeHello(1, 20), kNow);
  EXPECT_TRUE(fleet.Start().empty());
  EXPECT_TRUE(fleet.Join(MakeHello(7, 70), kNow).vehicle.empty()) << "any id may join";
  EXPECT_THAT(fleet.Share(7), ::testing::UnorderedElementsAre(10, 20));
  EXPECT_THAT(fleet.Assignment(*fleet.Find(10)).vehicle, ElementsAre(0, 1));
  EXPECT_THAT(fleet.Assignment(*fleet.Find(20)).vehicle, ElementsAre(3, 4));
  EXPECT_TRUE(fleet.Settle().empty()) << "they have not heard of it";
  EXPECT_EQ(Take(&fleet, *fleet.Find(10), MakeSegment(2, 0, 0, 3)), Fleet::Verdict::kSound) << "made before";
  Settle(&fleet, 10);
  fleet.Find(10)->status.last_sequence = 5;
  EXPECT_TRUE(fleet.Settle().empty()) << "something is still on the way";
  Settle(&fleet, 10);
  EXPECT_THAT(fleet.Settle(), ElementsAre(70));
  const Welcome welcome = fleet.Assignment(*fleet.Find(70));
  EXPECT_THAT(welcome.vehicle, ElementsAre(2));
  EXPECT_THAT(welcome.next_episode, ElementsAre(1));
  EXPECT_THAT(welcome.steps_done, ElementsAre(3));
  Settle(&fleet, 20);
  EXPECT_THAT(fleet.Settle(), ElementsAre(70));
  EXPECT_THAT(fleet.Assignment(*fleet.Find(70)).vehicle, ElementsAre(2, 5));
  EXPECT_EQ(Take(&fleet, *fleet.Find(70), MakeSegment(2, 1, 0, 1)), Fleet::Verdict::kSound);
  EXPECT_EQ(Take(&fleet, *fleet.Find(10), MakeSegment(2, 0, 3, 1)), Fleet::Verdict::kForeign);
}

TEST(FleetTest, AnActorThatLeavesIsForgottenWhenOthersHaveItsVehicles) {
  Fleet fleet = MakeFleet(2, 4);
  fleet.Join(MakeHello(0, 10), kNow);
  fleet.Join(MakeHello(1, 20), kNow);
  fleet.Start();
  EXPECT_THAT(fleet.Leave(0), ElementsAre(10));
  EXPECT_TRUE(fleet.Leave(0).empty()) << "said again";
  EXPECT_TRUE(fleet.Assignment(*fleet.Find(10)).vehicle.empty());
  EXPECT_FALSE(fleet.Gone(*fleet.Find(10)));
  Settle(&fleet, 10);
  EXPECT_THAT(fleet.Settle(), ElementsAre(20));
  EXPECT_TRUE(fleet.Gone(*fleet.Find(10)));
  EXPECT_THAT(fleet.Assignment(*fleet.Find(20)).vehicle, ElementsAre(0, 1, 2, 3));
  EXPECT_TRUE(fleet.Leave(1).empty()) << "nobody could take over";
  Settle(&fleet, 20);
  EXPECT_FALSE(fleet.Gone(*fleet.Find(20)));
}

TEST(FleetTest, AnHeirThatDiesBeforeItInheritsIsReplaced) {
  Fleet fleet = MakeFleet(3, 3);
  for (int i = 0; i < 3; ++i) fleet.Join(MakeHello(i, 10 + i), kNow);
  fleet.Start();
  fleet.Leave(0);
  fleet.Reassign(1);
  Settle(&fleet, 10);
  fleet.Settle();
  EXPECT_THAT(fleet.Assignment(*fleet.Find(12)).vehicle, ElementsAre(0, 1, 2));
}

TEST(FleetTest, AnActorStaysWhenAllOthersAreLeaving) {
  Fleet fleet = MakeFleet(2, 2);
  fleet.Join(MakeHello(0, 10), kNow);
  fleet.Join(MakeHello(1, 20), kNow);
  fleet.Start();
  fleet.Leave(1);
  EXPECT_FALSE(fleet.HasOther(0));
  EXPECT_TRUE(fleet.Reassign(0).empty());
  EXPECT_NE(fleet.Find(10), nullptr) << "or its vehicles would be nobody's";
}

CoordinatorState TwoSessions() {
  CoordinatorState state;
  state.vehicles.resize(4);
  for (size_t v = 0; v < 4; ++v) state.vehicles[v] = {2, 1, 5, true, -1, 30, {}, static_cast<int32_t>(v / 2)};
  state.sessions = {{0, 10, 0, 8, 100, 60, 70}, {1, 20, 0, 9, 200, 60, 70}};
  return state;
}

TEST(FleetTest, ASessionOfTheCheckpointGoesOnWhereItWas) {
  Fleet fleet = MakeFleet(2, 4);
  fleet.Restore(TwoSessions());
  EXPECT_EQ(fleet.Find(10), nullptr) << "not heard of yet";
  Hello hello = MakeHello(0, 10);
  hello.transitions = 75;
  const Welcome welcome = fleet.Join(hello, kNow);
  EXPECT_EQ(welcome.status, Welcome::Status::kAccepted);
  EXPECT_EQ(welcome.received, 100);
  EXPECT_EQ(welcome.assignment, 8);
  EXPECT_THAT(welcome.vehicle, ElementsAre(0, 1));
  EXPECT_EQ(fleet.Find(10)->credit, 75) << "what it has made counts";
  EXPECT_EQ(Take(&fleet, *fleet.Find(10), MakeSegment(0, 1, 5, 2)), Fleet::Verdict::kSound) << "in mid-episode";
  EXPECT_FALSE(fleet.complete());
  // The other's process is a new one: its vehicles begin new episodes.
  EXPECT_EQ(fleet.Join(MakeHello(1, 21, 1), kNow).received, 0);
  EXPECT_TRUE(fleet.complete());
  EXPECT_EQ(Take(&fleet, *fleet.Find(21), MakeSegment(2, 1, 5, 2)), Fleet::Verdict::kGap);
  EXPECT_EQ(Take(&fleet, *fleet.Find(21), MakeSegment(2, 2, 0, 2)), Fleet::Verdict::kSound);
}

TEST(FleetTest, ASessionThatNobodyKnowsMustBeginAnew) {
  Fleet fleet = MakeFleet(2, 4);
  fleet.Restore(TwoSessions());
  Hello hello = MakeHello(0, 99);
  hello.transitions = 1;
  EXPECT_EQ(fleet.Join(hello, kNow).status, Welcome::Status::kUnknown);
  EXPECT_EQ(fleet.Join(MakeHello(0, 100), kNow).status, Welcome::Status::kAccepted);
}

TEST(FleetTest, VehiclesOfSessionsThatDidNotComeBackGoToThoseThatDid) {
  Fleet fleet = MakeFleet(1, 4);
  fleet.Restore(TwoSessions());
  fleet.Join(MakeHello(0, 10), kNow);
  EXPECT_THAT(fleet.Start(), ElementsAre(10));
  EXPECT_THAT(fleet.Assignment(*fleet.Find(10)).vehicle, ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(fleet.actors().size(), 1u);
}

}  // namespace
}  // namespace cairn::learner
