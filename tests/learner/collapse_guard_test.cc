#include "learner/collapse_guard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <utility>

#include "tests/learner/fake_evaluator.h"

namespace cairn::learner {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// "Learns" by counting.
class FakeAlgorithm final : public Algorithm {
 public:
  void Learn() { ++policy_[0]; }
  void Update(const ReplayBuffer&, int, double) override {}
  std::span<const float> policy_parameters() const override { return policy_; }
  UpdateInfo TakeInfo() override { return {}; }
  std::vector<StateArray> Save() override { return {{"policy", {static_cast<uint8_t>(policy_[0])}}}; }
  void Load(const std::vector<StateArray>&) override { FAIL() << "an optimizer of another age must not come back"; }
  void LoadNetworks(const std::vector<StateArray>& state) override { policy_[0] = state.at(0).data.at(0); }
  uint32_t WeightsCrc32c() const override { return 0; }

 private:
  std::vector<float> policy_{0.0f};
};

// One training run as far as evaluations see it: the policy of env step 100 n has version n and the parameter n.
struct TrainingRun {
  TrainingRun(const Experiment& experiment, Evaluator* evaluator)
      : evaluation(
            experiment.evaluation, experiment.learner.collapse_checks, evaluator, [] { return 0.0; },
            [](const EvaluationReport&, const EvaluationSummary&) {}),
        guard(experiment, &evaluation, &algorithm) {}

  void VisitAt(std::initializer_list<int64_t> env_steps) {
    for (const int64_t steps : env_steps) {
      if (steps % 100 == 0) algorithm.Learn();
      guard.BeforePublish(steps);
      published[steps / 100] = parameter();
      guard.Visit(steps, steps / 100);
    }
  }
  float parameter() const { return algorithm.policy_parameters()[0]; }

  FakeAlgorithm algorithm;
  EvaluationSchedule evaluation;
  CollapseGuard guard;
  std::map<int64_t, float> published;  // by version
};

class CollapseGuardTest : public ::testing::Test {
 protected:
  CollapseGuardTest() {
    experiment_.evaluation.interval_env_steps = 100;
    experiment_.evaluation.consumption_starts = 10;
    experiment_.evaluation.validation_starts = 50;
    experiment_.evaluation.validation_every = 1;
    experiment_.learner.collapse_checks = 2;
    experiment_.learner.on_collapse = LearnerConfig::OnCollapse::kRevertToBest;
    // Solved at 200 (the best) and 300, lost from 400 on.
    evaluator_.successes = [](const EvaluationRequest& r) {
      if (r.set == StartSet::kValidation) return r.version == 2 ? 50 : 49;
      return r.version == 2 || r.version == 3 ? 10 : 4;
    };
  }

  Experiment experiment_;
  FakeEvaluator evaluator_;
};

TEST_F(CollapseGuardTest, GoesBackToTheBestNetworksWhenTheTaskIsLost) {
  TrainingRun run(experiment_, &evaluator_);
  run.VisitAt({100, 200, 300, 400, 500});
  EXPECT_FLOAT_EQ(run.parameter(), 5) << "the second failed check is not in yet";
  EXPECT_THAT(run.guard.warning(), IsEmpty());
  run.VisitAt({600});
  EXPECT_FLOAT_EQ(run.parameter(), 2);
  EXPECT_THAT(run.guard.warning(), HasSubstr("back to the networks of 200 env steps"));
  EXPECT_THAT(evaluator_.parameters.back(), ElementsAre(2.0f)) << "and they are what is checked next";
  EXPECT_THAT(run.guard.candidates(), SizeIs(2)) << "the best and the one under evaluation";
  evaluator_.successes = [](const EvaluationRequest&) { return 1000; };
  run.VisitAt({700, 800});
  EXPECT_THAT(run.guard.warning(), IsEmpty()) << "solved again";
}

TEST_F(CollapseGuardTest, WhatIsPublishedUnderAVersionIsKeptAndEvaluatedUnderIt) {
  TrainingRun run(experiment_, &evaluator_);
  run.VisitAt({100, 200, 300, 400, 500, 600});
  EXPECT_FLOAT_EQ(run.published.at(6), 2) << "after the way back";
  ASSERT_EQ(evaluator_.asked.back().version, 6);
  EXPECT_THAT(evaluator_.parameters.back(), ElementsAre(run.published.at(6)));
  EXPECT_EQ(run.guard.candidates().at(6).at(0).data, (Bytes{2}));
}

TEST_F(CollapseGuardTest, ContinueOnlySaysIt) {
  experiment_.learner.on_collapse = LearnerConfig::OnCollapse::kContinue;
  TrainingRun run(experiment_, &evaluator_);
  run.VisitAt({100, 200, 300, 400, 500, 510, 520});
  EXPECT_FLOAT_EQ(run.parameter(), 5);
  EXPECT_THAT(run.guard.warning(), HasSubstr("collapsed"));
  EXPECT_THAT(run.guard.candidates(), IsEmpty());
}

TEST_F(CollapseGuardTest, HoveringIsSaid) {
  evaluator_.successes = [](const EvaluationRequest& r) { return r.version == 6 ? 1 : 0; };
  TrainingRun crashing(experiment_, &evaluator_);
  crashing.VisitAt({100, 200, 300, 400});
  EXPECT_THAT(crashing.guard.warning(), IsEmpty());
  evaluator_.failure = Outcome::kTimeout;
  TrainingRun run(experiment_, &evaluator_);
  run.VisitAt({100, 200});
  EXPECT_THAT(run.guard.warning(), IsEmpty()) << "one check is in";
  run.VisitAt({300});
  EXPECT_THAT(run.guard.warning(),
              HasSubstr("hovers: no consumption start is solved and most time out since 2 checks"));
}

TEST_F(CollapseGuardTest, HoveringIsSaidHoweverResultsComeInAndUntilItEnds) {
  evaluator_.successes = [](const EvaluationRequest& r) { return r.version == 6 ? 1 : 0; };
  evaluator_.failure = Outcome::kTimeout;
  experiment_.learner.on_collapse = LearnerConfig::OnCollapse::kContinue;
  TrainingRun run(experiment_, &evaluator_);
  run.VisitAt({100, 200});
  std::vector<EvaluationReport> late = std::exchange(evaluator_.ready, {});
  run.VisitAt({300});
  late.insert(late.end(), evaluator_.ready.begin(), evaluator_.ready.end());
  evaluator_.ready = std::move(late);
  run.VisitAt({310});
  EXPECT_THAT(run.guard.warning(), HasSubstr("hovers")) << "three checks at once, between two checks";
  run.VisitAt({400, 500, 600, 610});
  EXPECT_THAT(run.guard.warning(), IsEmpty()) << "one start was solved";
}

TEST_F(CollapseGuardTest, LockstepActsAtChecksOnlyWheneverResultsComeIn) {
  TrainingRun run(experiment_, &evaluator_);
  run.VisitAt({100, 200, 300, 400, 500, 510, 520});
  EXPECT_FLOAT_EQ(run.parameter(), 5) << "known at 510";
  run.VisitAt({600});
  EXPECT_FLOAT_EQ(run.parameter(), 2);
}

TEST_F(CollapseGuardTest, AsyncActsAtOnce) {
  experiment_.schedule = Schedule::kAsync;
  TrainingRun run(experiment_, &evaluator_);
  run.VisitAt({100, 200, 210, 300, 310, 400, 410, 500, 510, 520});
  EXPECT_FLOAT_EQ(run.parameter(), 2);
}

TEST_F(CollapseGuardTest, ARunThatGoesOnStillHasTheBestNetworks) {
  TrainingRun first(experiment_, &evaluator_);
  first.VisitAt({100, 200, 300, 400, 500, 510});
  TrainingRun second(experiment_, &evaluator_);
  second.evaluation.Restore(first.evaluation.State());
  second.evaluation.AskAgain(first.evaluation.State());
  second.guard.Restore(first.guard.candidates());
  second.VisitAt({600});
  EXPECT_FLOAT_EQ(second.parameter(), 2);
}

}  // namespace
}  // namespace cairn::learner
