#include "learner/evaluation_schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/learner/fake_evaluator.h"

namespace cairn::learner {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class EvaluationScheduleTest : public ::testing::Test {
 protected:
  EvaluationScheduleTest() {
    config_.interval_env_steps = 100;
    config_.consumption_starts = 10;
    config_.validation_starts = 50;
    config_.test_starts = 200;
    config_.validation_every = 2;
  }

  EvaluationSchedule Make() {
    return {config_, 2, &evaluator_, [this] { return wall_s_; },
            [this](const EvaluationReport& report, const EvaluationSummary&) { reported_.push_back(report.request); }};
  }

  void VisitAt(EvaluationSchedule* schedule, int64_t env_steps) {
    wall_s_ = static_cast<double>(env_steps) / 10;
    const std::vector<float> parameters{static_cast<float>(env_steps)};
    schedule->Visit(env_steps, env_steps, parameters);
    schedule->Receive(false);
    schedule->Receive(false);  // a validation that the consumption check asked for
  }

  EvaluationConfig config_;
  FakeEvaluator evaluator_;
  double wall_s_ = 0;
  std::vector<EvaluationRequest> reported_;
};

TEST_F(EvaluationScheduleTest, ChecksAtTheFirstVersionPublishedAfterEachInterval) {
  EvaluationSchedule schedule = Make();
  for (const int64_t steps : {64, 128, 192, 256, 320, 660, 690, 704}) VisitAt(&schedule, steps);
  EXPECT_THAT(evaluator_.Versions(StartSet::kConsumption), ElementsAre(128, 256, 320, 660, 704));
}

TEST_F(EvaluationScheduleTest, ConsumptionIsTheFirstCheckWithAllStartsSolvedAtItsVersionsSteps) {
  evaluator_.successes = [](const EvaluationRequest& r) { return r.version < 300 || r.version == 400 ? 9 : 10; };
  EvaluationSchedule schedule = Make();
  EXPECT_EQ(schedule.last_solved(), -1);
  VisitAt(&schedule, 100);
  VisitAt(&schedule, 200);
  EXPECT_EQ(schedule.consumption_env_steps(), -1);
  EXPECT_EQ(schedule.last_solved(), 9);
  VisitAt(&schedule, 300);
  EXPECT_EQ(schedule.consumption_env_steps(), 300);
  EXPECT_DOUBLE_EQ(schedule.consumption_wall_s(), 30);
  EXPECT_DOUBLE_EQ(schedule.stays_solved(), 1) << "no later check yet";
  VisitAt(&schedule, 400);
  VisitAt(&schedule, 500);
  EXPECT_EQ(schedule.consumption_env_steps(), 300);
  EXPECT_DOUBLE_EQ(schedule.stays_solved(), 0.5);
}

TEST_F(EvaluationScheduleTest, ValidatesOnlySolvedChecksAndOnlyEveryFewOfThem) {
  evaluator_.successes = [](const EvaluationRequest& r) { return r.version == 300 ? 9 : 1000; };
  EvaluationSchedule schedule = Make();
  for (int64_t steps = 100; steps <= 700; steps += 100) VisitAt(&schedule, steps);
  EXPECT_THAT(evaluator_.Versions(StartSet::kValidation), ElementsAre(100, 500, 700)) << "checks 0, 2, 4, 6; 2 failed";
}

TEST_F(EvaluationScheduleTest, WithoutASolvedCheckThoseThatSolvedHalfAreValidated) {
  evaluator_.successes = [](const EvaluationRequest& r) {
    return r.set == StartSet::kConsumption ? (r.version == 700 ? 4 : 5) : r.version == 300 ? 40 : 39;
  };
  EvaluationSchedule schedule = Make();
  for (int64_t steps = 100; steps <= 700; steps += 100) VisitAt(&schedule, steps);
  EXPECT_THAT(evaluator_.Versions(StartSet::kValidation), ElementsAre(300, 500)) << "not check 0; 6 solved too few";
  ASSERT_TRUE(schedule.Test({750, 750, {7.5f}}));
  EXPECT_THAT(evaluator_.Versions(StartSet::kValidation), ElementsAre(300, 500, 750));
  EXPECT_THAT(evaluator_.Versions(StartSet::kTest), ElementsAre(300));
}

TEST_F(EvaluationScheduleTest, TheFirstSolvedCheckGoesBeforeWhatSolvedSome) {
  evaluator_.successes = [](const EvaluationRequest& r) {
    return r.set == StartSet::kConsumption ? (r.version < 400 ? 9 : 10) : r.version == 300 ? 50 : 40;
  };
  EvaluationSchedule schedule = Make();
  for (int64_t steps = 100; steps <= 300; steps += 100) VisitAt(&schedule, steps);
  ASSERT_TRUE(schedule.best());
  EXPECT_EQ(schedule.best()->version, 300);
  VisitAt(&schedule, 400);
  EXPECT_FALSE(schedule.best());
  VisitAt(&schedule, 500);
  ASSERT_TRUE(schedule.best());
  EXPECT_EQ(schedule.best()->version, 500);
}

// Whichever answer comes first.
TEST_F(EvaluationScheduleTest, AValidationThatComesAfterTheFirstSolvedCheckIsOvertaken) {
  evaluator_.successes = [](const EvaluationRequest& r) { return r.version < 400 ? 9 : 1000; };
  EvaluationSchedule schedule = Make();
  VisitAt(&schedule, 100);
  VisitAt(&schedule, 200);
  evaluator_.answering = false;
  VisitAt(&schedule, 300);
  EvaluationState state = schedule.State();
  ASSERT_EQ(state.asked.size(), 1u);
  state.asked.front().request.set = StartSet::kValidation;
  state.consumption_env_steps = 400;
  evaluator_.answering = true;
  EvaluationSchedule second = Make();
  second.Restore(state);
  second.AskAgain(state);
  second.Receive(true);
  EXPECT_FALSE(second.best());
}

TEST_F(EvaluationScheduleTest, TestsTheBestValidatedPolicyOnce) {
  evaluator_.successes = [](const EvaluationRequest& r) {
    return r.set != StartSet::kValidation ? 1000 : r.version == 300 ? 50 : 49;
  };
  EvaluationSchedule schedule = Make();
  for (int64_t steps = 100; steps <= 500; steps += 100) VisitAt(&schedule, steps);
  const auto test = schedule.Test({520, 520, {520.0f}});
  ASSERT_TRUE(test);
  EXPECT_EQ(test->trials, 200);
  EXPECT_THAT(evaluator_.Versions(StartSet::kTest), ElementsAre(300));
  EXPECT_THAT(evaluator_.parameters.back(), ElementsAre(300.0f));
  EXPECT_THAT(evaluator_.Versions(StartSet::kValidation), ElementsAre(100, 300, 500, 520)) << "the last one as well";
}

TEST_F(EvaluationScheduleTest, TheLastPolicyIsNotValidatedTwice) {
  evaluator_.successes = [](const EvaluationRequest& r) {
    return r.set != StartSet::kValidation ? 1000 : r.version == 300 ? 50 : 49;
  };
  EvaluationSchedule schedule = Make();
  for (int64_t steps = 100; steps <= 500; steps += 100) VisitAt(&schedule, steps);
  ASSERT_TRUE(schedule.Test({500, 500, {500.0f}}));
  EXPECT_THAT(evaluator_.Versions(StartSet::kValidation), ElementsAre(100, 300, 500)) << "by the check just before";
  EXPECT_THAT(evaluator_.Versions(StartSet::kTest), ElementsAre(300));
}

TEST_F(EvaluationScheduleTest, EqualSuccessIsDecidedByTimeThenByAge) {
  evaluator_.duration = [](const EvaluationRequest& r) { return r.version == 100 ? 4.0f : 5.0f; };
  EvaluationSchedule schedule = Make();
  for (int64_t steps = 100; steps <= 500; steps += 100) VisitAt(&schedule, steps);
  ASSERT_TRUE(schedule.best());
  EXPECT_EQ(schedule.best()->version, 100) << "faster";
  evaluator_.duration = [](const EvaluationRequest&) { return 4.0f; };
  VisitAt(&schedule, 600);
  VisitAt(&schedule, 700);
  EXPECT_EQ(schedule.best()->version, 700) << "as fast, and has seen more";
}

TEST_F(EvaluationScheduleTest, WithoutASolvedCheckTheLastPolicyIsTested) {
  evaluator_.successes = [](const EvaluationRequest&) { return 3; };
  EvaluationSchedule schedule = Make();
  VisitAt(&schedule, 100);
  const auto test = schedule.Test({150, 150, {1.5f}});
  ASSERT_TRUE(test);
  EXPECT_EQ(test->successes, 3);
  EXPECT_FALSE(schedule.best());
  EXPECT_THAT(evaluator_.Versions(StartSet::kTest), ElementsAre(150));
  EXPECT_TRUE(evaluator_.Versions(StartSet::kValidation).empty());
}

TEST_F(EvaluationScheduleTest, AStoppedRunHasNoTest) {
  evaluator_.answering = false;
  EvaluationSchedule schedule = Make();
  VisitAt(&schedule, 100);
  evaluator_.is_stopped = true;
  EXPECT_FALSE(schedule.Test({150, 150, {1.5f}}));
  EXPECT_TRUE(evaluator_.Versions(StartSet::kTest).empty());
}

TEST_F(EvaluationScheduleTest, CollapseIsSaidWhenHalfOfASolvedTaskFailsForSeveralChecks) {
  std::map<int64_t, int> solved{{100, 3}, {200, 3}, {300, 10}, {400, 5}, {500, 9}, {600, 5}, {700, 4}, {800, 3}};
  evaluator_.successes = [&](const EvaluationRequest& r) { return solved.contains(r.version) ? solved[r.version] : 9; };
  EvaluationSchedule schedule = Make();
  for (int64_t steps = 100; steps <= 600; steps += 100) {
    VisitAt(&schedule, steps);
    EXPECT_FALSE(schedule.TakeCollapse()) << steps;
  }
  VisitAt(&schedule, 700);
  EXPECT_TRUE(schedule.TakeCollapse());
  EXPECT_FALSE(schedule.TakeCollapse());
  VisitAt(&schedule, 800);
  EXPECT_FALSE(schedule.TakeCollapse()) << "said every other check";
}

TEST_F(EvaluationScheduleTest, GoesOnFromItsStateAndAsksAgainForWhatWasNotAnswered) {
  EvaluationSchedule first = Make();
  VisitAt(&first, 100);
  VisitAt(&first, 200);
  evaluator_.answering = false;
  VisitAt(&first, 300);
  const EvaluationState state = first.State();
  ASSERT_EQ(state.asked.size(), 1u);
  evaluator_.asked.clear();
  evaluator_.parameters.clear();
  evaluator_.answering = true;
  EvaluationSchedule second = Make();
  second.Restore(state);
  EXPECT_EQ(second.consumption_env_steps(), 100);
  EXPECT_EQ(second.best()->version, 100);
  EXPECT_THAT(evaluator_.asked, IsEmpty()) << "nobody may be there yet";
  second.AskAgain(state);
  EXPECT_THAT(evaluator_.Versions(StartSet::kConsumption), ElementsAre(300));
  EXPECT_THAT(evaluator_.parameters.back(), ElementsAre(300.0f));
  VisitAt(&second, 310);
  EXPECT_EQ(second.consumption_env_steps(), 100);
  VisitAt(&second, 400);
  EXPECT_THAT(evaluator_.Versions(StartSet::kConsumption), ElementsAre(300, 400));
  EXPECT_THAT(evaluator_.Versions(StartSet::kValidation), ElementsAre(300)) << "numbers of checks go on";
  EXPECT_EQ(second.best()->version, 300);
}

}  // namespace
}  // namespace cairn::learner
