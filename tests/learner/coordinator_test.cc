#include "learner/coordinator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/core/hash.h"
#include "common/core/version.h"

namespace cairn::learner {
namespace {

constexpr int kCarActions = 2;  // speed and yaw rate

using std::chrono::milliseconds;

constexpr uint64_t kHash = 0x1234;

Experiment MakeExperiment(Schedule schedule) {
  Experiment e;
  e.schedule = schedule;
  e.num_vehicles = 4;
  e.total_env_steps = 100;
  e.transport.base_port = 22000;
  e.seed = static_cast<uint64_t>(RandomId());
  return e;
}

// The other end of the conversation, as an actor process holds it, with made-up transitions.
class FakeActor {
 public:
  FakeActor(const Experiment& experiment, int actor_id, int generation = 0)
      : experiment_(experiment), id_(actor_id), bus_(Config(experiment)) {
    hello_.session = bus_.config().session;
    hello_.experiment_hash = kHash;
    hello_.incarnation = 1;
    hello_.actor_id = actor_id;
    hello_.generation = generation;
    hello_.observation_size = ObservationSize(experiment);
    hello_.git_revision = GitRevision();
    bus_.Subscribe<Welcome>(Plane::kControl, kWelcomeChannel, [this](const Welcome& w, const FrameInfo&) {
      if (w.session == hello_.session) welcome = w;
    });
    bus_.Subscribe<Control>(Plane::kControl, kControlChannel,
                            [this](const Control& c, const FrameInfo&) { control = c; });
    bus_.Subscribe<PolicyChunk>(Plane::kControl, kPolicyChannel,
                                [this](const PolicyChunk& c, const FrameInfo&) { policies.push_back(c); });
  }

  // The seed stands in for the run id, so that no test hears another.
  static BusConfig Config(const Experiment& e) {
    return {e.transport.group, e.transport.base_port, 0, static_cast<int64_t>(e.seed), RandomId()};
  }

  template <typename Done>
  bool Until(Done done) {
    for (const TimePoint end = Clock::now() + std::chrono::seconds(5); Clock::now() < end;) {
      if (done()) return true;
      bus_.Poll(milliseconds(5));
    }
    return false;
  }

  /// Until a control frame is here and `done` says so of it.
  template <typename Done>
  bool UntilControl(Done done) {
    return Until([&] { return control && done(); });
  }

  bool Join() {
    return Until([this] {
      if (!welcome) bus_.Publish(Plane::kExperience, kHelloChannel, hello_);
      return welcome.has_value();
    });
  }

  /// The oldest open round; number 0 when there is none.
  Control::Round round() const { return control && !control->rounds.empty() ? control->rounds[0] : Control::Round{}; }

  const Control::Actor* me() const {
    if (!control) return nullptr;
    for (const Control::Actor& a : control->actors) {
      if (a.session == hello_.session) return &a;
    }
    return nullptr;
  }

  // `steps` steps of a vehicle, ending its episode, with the policy and table in force.
  Segment Make(int vehicle, int episode, int steps) const {
    const auto observation = static_cast<size_t>(ObservationSize(experiment_));
    Segment s;
    s.vehicle = vehicle;
    s.episode = episode;
    s.end = SegmentEnd::kTruncated;
    s.table_hash = control->table_hash;
    s.policy_incarnation = control->incarnation;
    s.policy_version = control->rounds.empty() ? control->policy_version : control->rounds[0].policy_version;
    s.observations.assign(static_cast<size_t>(steps + 1) * observation, static_cast<float>(vehicle));
    s.actions.assign(static_cast<size_t>(steps) * kCarActions, 0.0f);
    s.rewards.assign(static_cast<size_t>(steps), static_cast<float>(episode));
    return s;
  }

  void Send(std::vector<Segment> segments, int64_t sequence, std::vector<EpisodeResult> episodes = {}) {
    Experience m;
    m.send_us = MonotonicUs();
    m.session = hello_.session;
    m.sequence = sequence;
    m.policy_incarnation = control->incarnation;
    m.actor_id = id_;
    m.observation_size = ObservationSize(experiment_);
    m.action_size = kCarActions;
    m.segments = std::move(segments);
    m.episodes = std::move(episodes);
    bus_.Publish(Plane::kExperience, ExperienceChannel(id_), m);
  }

  Bus& bus() { return bus_; }
  int64_t session() const { return hello_.session; }

  std::optional<Welcome> welcome;
  std::optional<Control> control;
  std::vector<PolicyChunk> policies;

 private:
  const Experiment& experiment_;
  int id_;
  Bus bus_;
  Hello hello_;
};

class CoordinatorTest : public ::testing::Test {
 protected:
  void Start(Schedule schedule, int num_actors) {
    experiment_ = MakeExperiment(schedule);
    bus_ = std::make_unique<Bus>(FakeActor::Config(experiment_));
    coordinator_ = std::make_unique<Coordinator>(bus_.get(), experiment_, kHash, num_actors, 1);
    coordinator_->Start();
    planner_ = std::make_unique<Bus>(FakeActor::Config(experiment_));
    for (int i = 0; i < num_actors; ++i) actors_.push_back(std::make_unique<FakeActor>(experiment_, i));
    const TableInfo info{.experiment_hash = kHash, .roadmap_hash = 8, .table_hash = 9};
    ASSERT_TRUE(actors_[0]->Until([&] {
      planner_->Publish(Plane::kTables, kTableInfoChannel, info);
      return actors_[0]->control && actors_[0]->control->table_hash == 9;
    }));
    for (auto& actor : actors_) ASSERT_TRUE(actor->Join());
    ASSERT_TRUE(coordinator_->WaitForFleet());
  }

  void TearDown() override {
    if (coordinator_) coordinator_->Finish();
  }

  Experiment experiment_;
  std::unique_ptr<Bus> bus_, planner_;
  std::unique_ptr<Coordinator> coordinator_;
  std::vector<std::unique_ptr<FakeActor>> actors_;
  const std::vector<float> policy_ = {1, 2, 3};
};

TEST_F(CoordinatorTest, LockstepRoundIsOrderedByVehicleWhateverTheOrderOfArrival) {
  Start(Schedule::kLockstep, 2);
  coordinator_->PublishPolicy(7, policy_);
  coordinator_->GrantRound(3, 1, false);
  for (auto& actor : actors_) {
    ASSERT_TRUE(actor->UntilControl([&] { return actor->round().round == 1; }));
    EXPECT_EQ(actor->round().policy_version, 7);
  }
  actors_[1]->Send({actors_[1]->Make(3, 0, 3), actors_[1]->Make(2, 0, 3)}, 1);
  actors_[0]->Send({actors_[0]->Make(0, 0, 4)}, 1);
  actors_[0]->Send({actors_[0]->Make(1, 0, 3)}, 2);
  const auto round = coordinator_->WaitRound();
  ASSERT_TRUE(round);
  std::vector<int> vehicles;
  for (const Segment& s : round->segments) vehicles.push_back(s.vehicle);
  EXPECT_THAT(vehicles, ::testing::ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(coordinator_->counters().transitions_accepted, 13);
  EXPECT_EQ(coordinator_->counters().transitions_lost, 0);
}

TEST_F(CoordinatorTest, APolicyPublishedDuringARoundCountsFromTheNextRoundOn) {
  Start(Schedule::kLockstep, 1);
  FakeActor& actor = *actors_[0];
  coordinator_->PublishPolicy(1, policy_);
  coordinator_->GrantRound(1, 0, false);
  coordinator_->PublishPolicy(2, policy_);
  ASSERT_TRUE(actor.UntilControl([&] { return actor.round().round == 1; }));
  // Several announcements later the round still has its version.
  const int64_t first = actor.control->number;
  ASSERT_TRUE(actor.UntilControl([&] { return actor.control->number > first + 2; }));
  EXPECT_EQ(actor.round().policy_version, 1);
  actor.Send({actor.Make(0, 0, 1), actor.Make(1, 0, 1), actor.Make(2, 0, 1), actor.Make(3, 0, 1)}, 1);
  ASSERT_TRUE(coordinator_->WaitRound());
  coordinator_->GrantRound(1, 0, false);
  ASSERT_TRUE(actor.UntilControl([&] { return actor.round().round == 2; }));
  EXPECT_EQ(actor.round().policy_version, 2);
}

TEST_F(CoordinatorTest, AnActorThatIsAheadFillsTheNextRoundWhileAnotherStillMakesThisOne) {
  Start(Schedule::kLockstep, 2);
  coordinator_->PublishPolicy(1, policy_);
  coordinator_->GrantRound(2, 0, false);
  coordinator_->PublishPolicy(2, policy_);
  coordinator_->GrantRound(3, 0, false);
  FakeActor& fast = *actors_[0];
  FakeActor& slow = *actors_[1];
  for (auto& actor : actors_) {
    ASSERT_TRUE(actor->UntilControl([&] { return actor->control->rounds.size() == 2; }));
  }
  const auto of_second = [&](Segment s) {
    s.policy_version = 2;
    return s;
  };
  EpisodeResult episode;
  episode.vehicle = 1;
  episode.episode = 1;
  fast.Send({fast.Make(0, 0, 2), fast.Make(1, 0, 2)}, 1);
  fast.Send({of_second(fast.Make(0, 1, 3)), of_second(fast.Make(1, 1, 3))}, 2, {episode});
  ASSERT_TRUE(fast.Until([&] { return fast.me() && fast.me()->received == 2; }));
  slow.Send({slow.Make(2, 0, 2), slow.Make(3, 0, 2)}, 1);
  const auto first = coordinator_->WaitRound();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->segments.size(), 4u);
  for (const Segment& s : first->segments) EXPECT_EQ(s.policy_version, 1);
  EXPECT_TRUE(first->episodes.empty()) << "its segment belongs to the second round";
  slow.Send({of_second(slow.Make(2, 1, 3)), of_second(slow.Make(3, 1, 3))}, 2);
  const auto second = coordinator_->WaitRound();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->segments.size(), 4u);
  EXPECT_EQ(second->episodes.size(), 1u);
  EXPECT_EQ(coordinator_->counters().refused, 0);
}

TEST_F(CoordinatorTest, MessagesCountOnceAndInOrderHoweverTheyArrive) {
  Start(Schedule::kLockstep, 1);
  FakeActor& actor = *actors_[0];
  coordinator_->PublishPolicy(0, policy_);
  coordinator_->GrantRound(2, 0, false);
  ASSERT_TRUE(actor.UntilControl([&] { return actor.round().round == 1; }));
  const std::vector<Segment> first{actor.Make(0, 0, 2), actor.Make(1, 0, 2)};
  const std::vector<Segment> second{actor.Make(2, 0, 2), actor.Make(3, 0, 2)};
  actor.Send(second, 2);  // overtook: kept until 1 is here
  actor.Send(first, 1);
  actor.Send(first, 1);
  actor.Send(second, 2);
  ASSERT_TRUE(coordinator_->WaitRound());
  ASSERT_TRUE(actor.Until([&] { return coordinator_->counters().stream_duplicates == 2; }));
  const CoordinatorCounters counters = coordinator_->counters();
  EXPECT_EQ(counters.transitions_accepted, 8);
  EXPECT_EQ(counters.transitions_duplicate, 0);
  ASSERT_TRUE(actor.Until([&] { return actor.me() && actor.me()->received == 2; }));
}

TEST_F(CoordinatorTest, AsyncCreditNeverExceedsWhatIsAllowedInAll) {
  Start(Schedule::kAsync, 2);
  coordinator_->PublishPolicy(0, policy_);
  const auto credit = [&] {
    int64_t sum = 0;
    for (auto& a : actors_[0]->control->actors) sum += a.credit;
    return sum;
  };
  coordinator_->SetAllowed(30, false);
  ASSERT_TRUE(actors_[0]->UntilControl([&] { return credit() == 30; }));
  // One actor uses its share, the other none: only what was used comes free again, and never beyond the total.
  ASSERT_TRUE(actors_[1]->UntilControl([&] { return actors_[1]->control->phase == Control::Phase::kRunning; }));
  actors_[1]->Send({actors_[1]->Make(2, 0, 15)}, 1);
  ASSERT_FALSE(coordinator_->Take(std::chrono::seconds(5)).segments.empty());
  coordinator_->SetAllowed(1000000, false);
  ASSERT_TRUE(actors_[0]->UntilControl([&] { return credit() == experiment_.total_env_steps; }));
}

TEST_F(CoordinatorTest, SmallAmountsOfCreditGatherButAreGivenInTime) {
  Start(Schedule::kAsync, 1);
  coordinator_->PublishPolicy(0, policy_);
  FakeActor& actor = *actors_[0];
  for (int64_t allowed = 1; allowed <= 20; ++allowed) {
    coordinator_->SetAllowed(allowed, false);
    ASSERT_TRUE(actor.Until([&] {
      coordinator_->SetAllowed(allowed, false);
      return actor.me() && actor.me()->credit == allowed;
    })) << allowed;
  }
}

TEST_F(CoordinatorTest, AReplacedActorGetsTheCreditItsPredecessorHadNotUsed) {
  Start(Schedule::kAsync, 1);
  coordinator_->PublishPolicy(0, policy_);
  coordinator_->SetAllowed(40, false);
  FakeActor& old = *actors_[0];
  ASSERT_TRUE(old.Until([&] { return old.me() && old.me()->credit == 40; }));
  old.Send({old.Make(0, 0, 10)}, 1);
  ASSERT_FALSE(coordinator_->Take(std::chrono::seconds(5)).segments.empty());
  FakeActor next(experiment_, 0, 1);
  ASSERT_TRUE(next.Join());
  EXPECT_EQ(next.welcome->next_episode, (std::vector<int32_t>{1, 0, 0, 0}));
  ASSERT_TRUE(next.Until([&] {
    coordinator_->SetAllowed(50, false);
    return next.me() && next.me()->credit == 40;  // 50 allowed, 10 accepted
  }));
  EXPECT_TRUE(coordinator_->counters().disturbed);
}

TEST_F(CoordinatorTest, EvaluationIsSharedOutAndCollectedOncePerStart) {
  Start(Schedule::kLockstep, 2);
  coordinator_->Evaluate({3, StartSet::kValidation, 5, 1000, 0}, policy_);
  std::vector<int> covered(5, 0);
  for (auto& actor : actors_) {
    ASSERT_TRUE(actor->UntilControl([&] { return actor->control->evaluation_id == 1; }));
    EXPECT_EQ(actor->control->evaluation_version, 3);
    const Control::Actor& me = *actor->me();
    std::vector<EpisodeResult> results;
    for (int i = me.evaluation_first; i < me.evaluation_first + me.evaluation_count; ++i) {
      ++covered[static_cast<size_t>(i)];
      EpisodeResult r;
      r.set = StartSet::kValidation;
      r.vehicle = i;
      r.episode = 1;
      r.steps = 10 + i;
      r.outcome = Outcome::kGoal;
      results.push_back(r);
      results.push_back(r);  // doubled on the way
    }
    actor->Send({}, 1, results);
  }
  EXPECT_THAT(covered, ::testing::Each(1));
  const auto reports = coordinator_->TakeEvaluations(true);
  ASSERT_EQ(reports.size(), 1u);
  ASSERT_EQ(reports[0].results.size(), 5u);
  EXPECT_EQ(reports[0].results[4].steps, 14);
  EXPECT_EQ(coordinator_->counters().eval_steps, 60);
}

TEST_F(CoordinatorTest, SendsAPolicyAgainToWhoeverLacksIt) {
  Start(Schedule::kLockstep, 1);
  FakeActor& actor = *actors_[0];
  coordinator_->PublishPolicy(4, policy_);
  ASSERT_TRUE(actor.Until([&] { return !actor.policies.empty(); }));
  actor.policies.clear();
  ActorStatus status;
  status.session = actor.session();
  status.wanted_policy_version = 4;
  ASSERT_TRUE(actor.Until([&] {
    actor.bus().Publish(Plane::kExperience, kStatusChannel, status);
    return !actor.policies.empty();
  }));
  EXPECT_EQ(actor.policies[0].parameters, policy_);
}

TEST_F(CoordinatorTest, SegmentsOfAnotherTableOrPolicyAreRefused) {
  Start(Schedule::kLockstep, 1);
  FakeActor& actor = *actors_[0];
  coordinator_->PublishPolicy(0, policy_);
  coordinator_->GrantRound(1, 0, false);
  ASSERT_TRUE(actor.UntilControl([&] { return actor.round().round == 1; }));
  Segment wrong_table = actor.Make(0, 0, 1);
  wrong_table.table_hash = 77;
  Segment wrong_policy = actor.Make(0, 0, 1);
  wrong_policy.policy_version = 5;
  actor.Send({wrong_table, wrong_policy, actor.Make(0, 0, 1), actor.Make(1, 0, 1), actor.Make(2, 0, 1)}, 1);
  actor.Send({actor.Make(3, 0, 1)}, 2);
  ASSERT_TRUE(coordinator_->WaitRound());
  EXPECT_EQ(coordinator_->counters().refused, 2);
  EXPECT_EQ(coordinator_->counters().transitions_accepted, 4);
}

TEST_F(CoordinatorTest, StopEndsEveryWait) {
  Start(Schedule::kLockstep, 1);
  coordinator_->PublishPolicy(0, policy_);
  coordinator_->GrantRound(1, 0, false);
  coordinator_->Evaluate({0, StartSet::kTest, 5, 0, 0}, policy_);
  coordinator_->Stop();
  EXPECT_FALSE(coordinator_->WaitRound());
  EXPECT_TRUE(coordinator_->TakeEvaluations(true).empty());
}

}  // namespace
}  // namespace cairn::learner
