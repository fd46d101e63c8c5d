#include "common/bus/codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/bus/frame.h"
#include "common/bus/state_assembler.h"
#include "common/core/random.h"

namespace cairn {
namespace {

Experience MakeExperience() {
  Experience m;
  m.send_us = 5;
  m.session = 77;
  m.sequence = 3;
  m.policy_incarnation = 99;
  m.actor_id = 2;
  m.observation_size = 3;
  m.action_size = 2;
  Segment a{.vehicle = 4, .episode = 1, .first_step = 7, .end = SegmentEnd::kTerminated, .table_hash = ~0ull};
  a.policy_incarnation = 99;
  a.policy_version = 12;
  a.observations = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  a.actions = {0.1f, 0.2f, 0.3f, 0.4f};
  a.rewards = {1, -2};
  Segment b = a;
  b.vehicle = 5;
  b.end = SegmentEnd::kNone;
  b.observations = {1, 2, 3, 4, 5, 6};
  b.actions = {0.5f, -0.5f};
  b.rewards = {0.25f};
  m.segments = {a, b};
  EpisodeResult e;
  e.set = StartSet::kTest;
  e.vehicle = 9;
  e.episode = 8;
  e.steps = 100;
  e.outcome = Outcome::kCollision;
  e.policy_version = 11;
  e.episode_return = 1.5f;
  e.path_length = 2.5f;
  e.min_clearance = -0.5f;
  e.filtered_steps = 9;
  m.episodes = {e};
  return m;
}

Control MakeControl() {
  Control m;
  m.utime = 1;
  m.incarnation = 2;
  m.table_hash = 0xFFFFFFFFFFFFFFFEull;
  m.phase = Control::Phase::kRunning;
  m.number = 12;
  m.rounds = {{3, 30, 0, 7, true}, {4, 40, 2, 8, false}};
  m.policy_version = 5;
  m.evaluation_id = 6;
  m.evaluation_set = StartSet::kValidation;
  m.actors = {{0, 10, 11, 12, 13, 14, 15, 16, 17, {}}, {1, 20, 21, 22, 23, 24, 25, 26, 27, {{22, 22}, {24, 30}}}};
  return m;
}

TEST(CodecTest, ExperienceRoundTrips) {
  const Experience sent = MakeExperience();
  const std::optional<Experience> got = Decode<Experience>(Encode(sent));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->session, 77);
  EXPECT_EQ(got->sequence, 3);
  ASSERT_EQ(got->segments.size(), 2u);
  EXPECT_EQ(got->segments[0].observations, sent.segments[0].observations);
  EXPECT_EQ(got->segments[0].table_hash, ~0ull);
  EXPECT_EQ(got->segments[1].actions, sent.segments[1].actions);
  EXPECT_EQ(got->segments[1].rewards, sent.segments[1].rewards);
  EXPECT_EQ(got->segments[0].end, SegmentEnd::kTerminated);
  EXPECT_EQ(got->segments[0].policy_incarnation, 99);
  ASSERT_EQ(got->episodes.size(), 1u);
  EXPECT_EQ(got->episodes[0].outcome, Outcome::kCollision);
  EXPECT_EQ(got->episodes[0].set, StartSet::kTest);
  EXPECT_EQ(got->episodes[0].min_clearance, -0.5f);
  EXPECT_EQ(got->episodes[0].filtered_steps, 9);
}

TEST(CodecTest, StatesRoundTripInPieces) {
  Experience sent = MakeExperience();
  const Bytes state{1, 2, 3, 4, 5, 6, 7};
  for (VehicleStatePiece& piece : SplitState(4, 60, state, 3)) sent.states.push_back(std::move(piece));
  ASSERT_EQ(sent.states.size(), 3u);
  const std::optional<Experience> got = Decode<Experience>(Encode(sent));
  ASSERT_TRUE(got);
  StateAssembler assembler;
  for (const size_t i : {2, 0, 0, 1}) {
    EXPECT_EQ(assembler.Find(4, 60), nullptr);
    assembler.Add(got->states[i]);
  }
  ASSERT_NE(assembler.Find(4, 60), nullptr);
  EXPECT_EQ(*assembler.Find(4, 60), state);
  EXPECT_EQ(assembler.Find(4, 61), nullptr);
  EXPECT_EQ(assembler.Find(5, 60), nullptr);
  assembler.Add({4, 70, 2, 0, {9}});
  EXPECT_EQ(assembler.Find(4, 60), nullptr) << "another state begins";
  assembler.Add({6, 0, 1 << 30, 0, {9}});
  assembler.Add({6, 0, 4, 2, {9, 9, 9}});
  EXPECT_EQ(assembler.Find(6, 0), nullptr) << "too large, or beyond its end";
}

TEST(CodecTest, GoalsOfTablesRoundTripAndMustBeSound) {
  WorldGoal goal(~0ull, {Vector3d(1, 2, 3), Vector3d(1.5, 2, 4)});
  const auto request = Decode<TableRequest>(Encode(TableRequest{.hash = 5, .goal = goal}));
  ASSERT_TRUE(request);
  EXPECT_EQ(request->goal, goal);
  const auto info = Decode<TableInfo>(Encode(TableInfo{.table_hash = 7, .goal = goal}));
  ASSERT_TRUE(info);
  EXPECT_EQ(info->goal, goal);
  EXPECT_EQ(info->table_hash, 7u);
  EXPECT_FALSE(Decode<TableRequest>(Encode(TableRequest{}))->goal);
  goal.max[1] = 1;
  EXPECT_FALSE(Decode<TableRequest>(Encode(TableRequest{.goal = goal}))) << "inside out";
  goal.max[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Decode<TableInfo>(Encode(TableInfo{.goal = goal})));
}

TEST(CodecTest, ControlRoundTrips) {
  const std::optional<Control> got = Decode<Control>(Encode(MakeControl()));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->table_hash, 0xFFFFFFFFFFFFFFFEull);
  EXPECT_EQ(got->number, 12);
  ASSERT_EQ(got->rounds.size(), 2u);
  EXPECT_TRUE(got->rounds[0].warm_up);
  EXPECT_EQ(got->rounds[1].round, 4);
  EXPECT_EQ(got->rounds[1].policy_version, 8);
  EXPECT_EQ(got->rounds[1].Target(1), 41);
  EXPECT_EQ(got->rounds[1].Target(2), 40);
  ASSERT_EQ(got->actors.size(), 2u);
  EXPECT_EQ(got->actors[1].session, 20);
  EXPECT_EQ(got->actors[1].evaluation_count, 27);
  EXPECT_TRUE(got->actors[0].gaps.empty());
  ASSERT_EQ(got->actors[1].gaps.size(), 2u);
  EXPECT_EQ(got->actors[1].gaps[1].first, 24);
  EXPECT_EQ(got->actors[1].gaps[1].last, 30);
  EXPECT_EQ(got->evaluation_set, StartSet::kValidation);
}

TEST(CodecTest, HelloAndWelcomeRoundTrip) {
  Hello hello;
  hello.session = 5;
  hello.experiment_hash = 1ull << 63;
  hello.actor_id = 3;
  hello.git_revision = "abc";
  hello.isa = "cpx";
  const auto got = Decode<Hello>(Encode(hello));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->experiment_hash, 1ull << 63);
  EXPECT_EQ(got->git_revision, "abc");
  EXPECT_EQ(got->protocol, kProtocolVersion);

  Welcome welcome;
  welcome.status = Welcome::Status::kRefused;
  welcome.reason = "because";
  welcome.vehicle = {1, 2};
  welcome.next_episode = {3, 4};
  welcome.steps_done = {5, 6};
  welcome.state_bytes = {0, 7};
  const auto back = Decode<Welcome>(Encode(welcome));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->reason, "because");
  EXPECT_EQ(back->steps_done, welcome.steps_done);
  EXPECT_EQ(back->state_bytes, welcome.state_bytes);
}

// Every strict prefix and every length with bytes added must be refused, and no bit flip may crash or make the decoder
// read outside (the sanitizers watch); a flip inside a frame is refused by the checksum or tag.
constexpr RunKey kKey{1, 2, 3};

template <typename Message>
void SurvivesDamage(const Message& message) {
  const Bytes good = Encode(message);
  ASSERT_TRUE(Decode<Message>(good));
  for (size_t n = 0; n < good.size(); ++n) EXPECT_FALSE(Decode<Message>(ByteSpan(good).first(n))) << n;
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_FALSE(Decode<Message>(longer));
  for (size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Bytes flipped = good;
    flipped[bit / 8] = static_cast<uint8_t>(flipped[bit / 8] ^ (1u << (bit % 8)));
    (void)Decode<Message>(flipped);
  }
  for (const FrameSeal& seal : {FrameSeal(7), FrameSeal(7, kKey)}) {
    Bytes frame = good;
    seal.Seal(Plane::kControl, {1, 2}, &frame);
    EXPECT_FALSE(seal.Open(Plane::kControl, frame).fault);
    for (size_t bit = 0; bit < 8 * frame.size(); ++bit) {
      Bytes flipped = frame;
      flipped[bit / 8] = static_cast<uint8_t>(flipped[bit / 8] ^ (1u << (bit % 8)));
      EXPECT_TRUE(seal.Open(Plane::kControl, flipped).fault) << bit;
    }
  }
}

TEST(CodecTest, EveryMessageSurvivesTruncationAndBitFlips) {
  SurvivesDamage(Echo{4, 32});
  SurvivesDamage(Hello{.session = 1, .git_revision = "r", .isa = "i"});
  SurvivesDamage(Welcome{.vehicle = {1}, .next_episode = {0}, .steps_done = {0}, .state_bytes = {9}, .reason = "x"});
  SurvivesDamage(ActorStatus{.session = 3});
  SurvivesDamage(MakeExperience());
  SurvivesDamage(MakeControl());
  SurvivesDamage(AssignedState{.session = 2, .piece = {3, 40, 10, 2, Bytes(5, 9)}});
  SurvivesDamage(PolicyChunk{.total = 10, .offset = 2, .parameters = {1, 2, 3}});
  SurvivesDamage(TableRequest{.hash = 5, .num_chunks = 3});
  SurvivesDamage(TableInfo{.num_vertices = 3});
  SurvivesDamage(TableRequest{.goal = WorldGoal(4, {Vector3d(1, 2, 3), Vector3d(4, 5, 6)})});
  SurvivesDamage(TableInfo{.goal = WorldGoal(4, {Vector3d(1, 2, 3), Vector3d(4, 5, 6)})});
  SurvivesDamage(TableChunk{.hash = 3, .total_bytes = 20, .chunk = 1, .chunk_bytes = 10, .data = Bytes(10, 7)});
  SurvivesDamage(LearnerTelemetry{.env_steps = 3, .phase = "training"});
  SurvivesDamage(ActorTelemetry{.actor_id = 3});
  SurvivesDamage(PlannerTelemetry{.num_vertices = 3});
  SurvivesDamage(RobotState{.utime = 3, .ranges = {1, 2}});
  SurvivesDamage(RobotCommand{.valid = 0.3, .command = {1, 2}, .note = "x"});
}

TEST(CodecTest, ATextWithNulInsideIsRefused) {
  Hello hello;
  hello.git_revision = "abcd";
  Bytes bytes = Encode(hello);
  ASSERT_TRUE(Decode<Hello>(bytes));
  *(std::search(bytes.begin(), bytes.end(), hello.git_revision.begin(), hello.git_revision.end()) + 1) = 0;
  EXPECT_FALSE(Decode<Hello>(bytes));
}

TEST(CodecTest, RandomBytesAreRefused) {
  RandomStream random(1, RandomPurpose::kTest);
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes(random.Below(200));
    for (uint8_t& b : bytes) b = static_cast<uint8_t>(random.NextU32());
    EXPECT_FALSE(Decode<Experience>(bytes));
    EXPECT_FALSE(Decode<Control>(bytes));
    EXPECT_FALSE(Decode<Hello>(bytes));
    EXPECT_FALSE(Decode<TableChunk>(bytes));
  }
}

TEST(CodecTest, RefusesSegmentsWhoseStepsDoNotMatchTheData) {
  Bytes bytes = Encode(MakeExperience());
  // num_steps[0] stands behind fingerprint, header and three int32 columns of two segments each.
  const size_t at = 8 + 5 * 8 + 8 * 4 + 3 * 2 * 4 + 3;
  ASSERT_EQ(bytes[at], 2);
  bytes[at] = 3;
  EXPECT_FALSE(Decode<Experience>(bytes));
}

}  // namespace
}  // namespace cairn
