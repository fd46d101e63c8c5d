// Runs that go on with another experiment.textproto than they were interrupted with.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>

#include "common/core/files.h"
#include "learner/checkpoint/checkpoint_file.h"
#include "learner/checkpoint/checkpointer.h"
#include "tests/integration/run_cairn.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;

constexpr int64_t kSteps = 12800;  // 20 rounds of 20 steps for 32 vehicles

class ResumeTest : public ::testing::Test {
 protected:
  std::filesystem::path Run() const { return directory_.path() / "run"; }
  std::filesystem::path log() const { return directory_.path() / "output.log"; }
  std::string Checkpoints() const { return (Run() / "checkpoints").string(); }
  std::filesystem::path Checkpoint(int64_t env_steps) const {
    return Run() / "checkpoints" / fmt::format("checkpoint-{:012}.ckpt", env_steps);
  }

  // A whole run, with as many checkpoints on the way as the disk allows.
  void Train(int64_t steps, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"--set", "lockstep.round_steps=20",
                                       "--set", "learner.checkpoint_interval_s=0.001",
                                       "--set", "learner.checkpoints_kept=1000"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ASSERT_EQ(RunCairn(SmallRun(Run(), steps, arguments), log()), 0) << ReadFile(log());
  }

  // As if the run had died with one of its first checkpoints, in which a round is open; that one's state.
  learner::RunState Interrupt() const {
    const std::vector<std::string> names = learner::ListCheckpoints(Checkpoints());
    EXPECT_GT(names.size(), 1u) << "one at the end only";
    for (size_t i = 1; i < names.size(); ++i) std::filesystem::remove(Run() / "checkpoints" / names[i]);
    std::filesystem::remove(Run() / "summary.json");
    const std::string path = (Run() / "checkpoints" / names[0]).string();
    return learner::DecodeCheckpoint(cairn::ReadFile(path), path);
  }

  void Edit(const std::string& from, const std::string& to) const {
    std::string text = ReadFile(Run() / "experiment.textproto");
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << text;
    std::ofstream(Run() / "experiment.textproto") << text.replace(at, from.size(), to);
  }

  void EditTotal(int64_t from, int64_t to) const {
    Edit(fmt::format("total_env_steps: {}", from), fmt::format("total_env_steps: {}", to));
  }

  int Resume() const { return RunCairn({"train", "--resume", Run().string(), "--quiet"}, log()); }
  nlohmann::json Summary() const { return ReadJson(Run() / "summary.json"); }

  TemporaryDirectory directory_;
};

TEST_F(ResumeTest, ALargerTotalGoesOnBehindALastRoundThatIsOpen) {
  Train(kSteps);
  learner::RunState state = Interrupt();
  ASSERT_EQ(state.coordinator.granted.size(), 1u);
  // As if the total had been five steps behind that round.
  state.coordinator.granted[0].extra = 5;
  state.granted += 5;
  WriteFileAtomically(Checkpoint(state.env_steps).string(), learner::EncodeCheckpoint(state));
  EditTotal(kSteps, state.granted + 63);
  EXPECT_EQ(Resume(), 2);
  EXPECT_THAT(ReadFile(log()), HasSubstr("goes on for at least 64 more, two for each vehicle"));
  EditTotal(state.granted + 63, state.granted + 64);
  ASSERT_EQ(Resume(), 0) << ReadFile(log());
  EXPECT_EQ(Summary()["env_steps"], state.granted + 64);
  EXPECT_TRUE(std::filesystem::exists(Checkpoint(state.granted + 64)));
}

TEST_F(ResumeTest, ASmallerTotalEndsWithTheRoundsThatWereOpen) {
  Train(kSteps);
  const learner::RunState state = Interrupt();
  ASSERT_LT(state.env_steps, state.granted);
  EditTotal(kSteps, state.env_steps + 1);
  ASSERT_EQ(Resume(), 0) << ReadFile(log());
  EXPECT_EQ(Summary()["completed"], true);
  EXPECT_EQ(Summary()["env_steps"], state.granted);
  EXPECT_TRUE(std::filesystem::exists(Checkpoint(state.granted)));
}

TEST_F(ResumeTest, AFinishedRunThatGoesOnOverlapsItsRoundsAgain) {
  Train(3010, {"--set", "lockstep.overlap=false"});
  EXPECT_EQ(Summary()["policy_lag_mean"], 0.0);
  EditTotal(3010, kSteps);
  Edit("overlap: false", "overlap: true");
  ASSERT_EQ(Resume(), 0) << ReadFile(log());
  EXPECT_EQ(Summary()["env_steps"], kSteps);
  EXPECT_GT(Summary()["policy_lag_mean"], 0.0);
}

// No actor comes, so that it is stopped before training goes on.
TEST_F(ResumeTest, OneThatIsStoppedBeforeItsActorsAreThereStillTellsWhatItKnew) {
  Train(kSteps);
  learner::RunState state = Interrupt();
  state.evaluation.consumption_env_steps = 600;
  state.evaluation.consumption_wall_s = 0.5;
  state.evaluation.best = state.coordinator.granted.at(0).policy;
  WriteFileAtomically(Checkpoint(state.env_steps).string(), learner::EncodeCheckpoint(state));
  Program learner("cairn-learner",
                  {(Run() / "experiment.textproto").string(), "--run-id", "1f", "--run-dir", Run().string(), "--resume",
                   "--actors", "1", "--lcm-url", "udpm://239.255.76.67:7700?ttl=0"},
                  log());
  ASSERT_TRUE(WaitUntil(learner, [this] { return ReadFile(log()).find("resumed at") != std::string::npos; }))
      << ReadFile(log());
  kill(learner.pid(), SIGTERM);
  EXPECT_EQ(learner.Wait(), 1) << ReadFile(log());
  const nlohmann::json summary = Summary();
  EXPECT_EQ(summary["completed"], false);
  EXPECT_EQ(summary["env_steps"], state.env_steps);
  EXPECT_EQ(summary["consumption_env_steps"], 600);
  EXPECT_EQ(summary["consumption_wall_s"], 0.5);
  EXPECT_EQ(summary["policy_tested"], "best");
  EXPECT_EQ(summary["training_s"], 0.0);
}

}  // namespace
}  // namespace cairn::testing
