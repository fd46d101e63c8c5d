// Whole runs over real processes and LCM, small ones: what they promise about accounting, determinism and failure.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "common/core/clock.h"
#include "tests/integration/run_cairn.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;

// episodes.csv without its last column, which is wall-clock time.
std::string EpisodesWithoutTime(const std::filesystem::path& run_dir) {
  std::istringstream file(ReadFile(run_dir / "episodes.csv"));
  std::string text;
  for (std::string line; std::getline(file, line);) text += line.substr(0, line.rfind(',')) + "\n";
  return text;
}

class TrainTest : public ::testing::Test {
 protected:
  std::filesystem::path Dir(const std::string& name) const { return directory_.path() / name; }
  std::filesystem::path log() const { return directory_.path() / "output.log"; }
  std::map<std::string, std::string> Audit() {
    std::filesystem::create_directories(Dir("audit"));
    return {{"CAIRN_AUDIT_DIR", Dir("audit").string()}};
  }

  TemporaryDirectory directory_;
};

TEST_F(TrainTest, LockstepGivesTheSameBitsWithOneTwoAndThreeActors) {
  std::string weights, episodes;
  for (const std::string actors : {"1", "2", "3", "1"}) {
    const std::filesystem::path run = Dir("run" + actors + (weights.empty() ? "" : "b"));
    ASSERT_EQ(RunCairn(SmallRun(run, 3010, {"--actors", actors}), log()), 0) << ReadFile(log());
    const nlohmann::json summary = ReadJson(run / "summary.json");
    EXPECT_EQ(summary["env_steps"], 3010);
    EXPECT_EQ(summary["deterministic"], true);
    if (weights.empty()) {
      weights = summary["weights_crc32c"];
      episodes = EpisodesWithoutTime(run);
      EXPECT_GT(std::count(episodes.begin(), episodes.end(), '\n'), 20);
    }
    EXPECT_EQ(summary["weights_crc32c"], weights) << actors;
    EXPECT_EQ(EpisodesWithoutTime(run), episodes) << actors;
  }
}

TEST_F(TrainTest, AnotherSeedGivesOtherWeights) {
  ASSERT_EQ(RunCairn(SmallRun(Dir("a"), 1500, {"--seed", "1"}), log()), 0) << ReadFile(log());
  ASSERT_EQ(RunCairn(SmallRun(Dir("b"), 1500, {"--seed", "2"}), log()), 0) << ReadFile(log());
  EXPECT_NE(ReadJson(Dir("a") / "summary.json")["weights_crc32c"],
            ReadJson(Dir("b") / "summary.json")["weights_crc32c"]);
}

// 32 vehicles, rounds of 20 steps: ten steps are left after eight whole rounds.
TEST_F(TrainTest, ALockstepRunEndsWithACheckpointWhateverItsTotal) {
  ASSERT_EQ(RunCairn(SmallRun(Dir("run"), 5130, {"--set", "lockstep.round_steps=20"}), log()), 0) << ReadFile(log());
  EXPECT_TRUE(std::filesystem::exists(Dir("run") / "checkpoints" / "checkpoint-000000005130.ckpt"));
  EXPECT_EQ(ReadJson(Dir("run") / "summary.json")["env_steps"], 5130);
}

TEST_F(TrainTest, LockstepLosesAndDoublesNothing) {
  ASSERT_EQ(RunCairn(SmallRun(Dir("run"), 3010, {"--actors", "2"}), log(), Audit()), 0) << ReadFile(log());
  const nlohmann::json summary = ReadJson(Dir("run") / "summary.json");
  EXPECT_EQ(summary["transitions_lost"], 0);
  EXPECT_EQ(summary["transitions_duplicate"], 0);
  ExpectReplayMatchesActors(Dir("audit"), 3010, false);
}

TEST_F(TrainTest, AsyncLosesAndDoublesNothingAndEndsExactly) {
  ASSERT_EQ(RunCairn(SmallRun(Dir("run"), 5003, {"--actors", "2", "--set", "schedule=ASYNC"}), log(), Audit()), 0)
      << ReadFile(log());
  const nlohmann::json summary = ReadJson(Dir("run") / "summary.json");
  EXPECT_EQ(summary["env_steps"], 5003);
  EXPECT_EQ(summary["updates"], (5003 - 500) / 10);
  EXPECT_EQ(summary["transitions_lost"], 0);
  EXPECT_EQ(summary["transitions_duplicate"], 0);
  EXPECT_EQ(summary["deterministic"], false);
  ExpectReplayMatchesActors(Dir("audit"), 5003, false);
}

TEST_F(TrainTest, AsyncGoesOnWhenUpdatesNeedMoreThanTheErrorBuffer) {
  Program train("cairn",
                SmallRun(Dir("run"), 5003,
                         {"--set", "schedule=ASYNC", "--set", "async.error_buffer=300", "--set",
                          "learner.train_freq=1000", "--set", "learner.gradient_steps=10"}),
                log());
  ASSERT_EQ(train.WaitFor(std::chrono::seconds(60)), 0) << ReadFile(log());
  EXPECT_EQ(ReadJson(Dir("run") / "summary.json")["updates"], (5003 - 500) / 1000 * 10);
}

TEST_F(TrainTest, Td3WithoutOverlapRuns) {
  ASSERT_EQ(RunCairn(SmallRun(Dir("run"), 1500, {"--set", "learner.algorithm=TD3", "--set", "lockstep.overlap=false"}),
                     log()),
            0)
      << ReadFile(log());
  EXPECT_EQ(ReadJson(Dir("run") / "summary.json")["policy_lag_mean"], 0.0);
}

// Until a run has written its first episodes, so that it is in the middle of training.
bool WaitForTraining(const std::filesystem::path& run_dir, const Program& program) {
  return WaitUntil(program, [&] {
    std::error_code error;
    return std::filesystem::file_size(run_dir / "episodes.csv", error) > 1000 && !error;
  });
}

// Until there is a checkpoint to go on from.
bool WaitForCheckpoint(const std::filesystem::path& run_dir, const Program& program) {
  return WaitUntil(program, [&] {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(run_dir / "checkpoints", error)) {
      if (entry.path().extension() == ".ckpt") return true;
    }
    return false;
  });
}

void KillOneActor(const std::string& schedule, const std::filesystem::path& run, const std::filesystem::path& log,
                  const std::filesystem::path& audit) {
  Program train(
      "cairn",
      SmallRun(run, 150000,
               {"--actors", "2", "--set", "schedule=" + schedule, "--set", "evaluation.interval_env_steps=20000"}),
      log, {{"CAIRN_AUDIT_DIR", audit.string()}});
  ASSERT_TRUE(WaitForTraining(run, train)) << ReadFile(log);
  const std::vector<pid_t> actors = Descendants(train.pid(), "cairn-actor");
  ASSERT_EQ(actors.size(), 2u);
  ASSERT_EQ(kill(actors[0], SIGKILL), 0);
  EXPECT_EQ(train.Wait(), 0) << ReadFile(log);
  const nlohmann::json summary = ReadJson(run / "summary.json");
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["env_steps"], 150000);
  EXPECT_EQ(summary["transitions_lost"], 0);
  EXPECT_EQ(summary["deterministic"], false);
  ExpectReplayMatchesActors(audit, 150000, true);
}

TEST_F(TrainTest, AKilledActorIsReplacedAndALockstepRunEndsWell) {
  Audit();
  KillOneActor("LOCKSTEP", Dir("run"), log(), Dir("audit"));
}

TEST_F(TrainTest, AKilledActorIsReplacedAndAnAsyncRunEndsWell) {
  Audit();
  KillOneActor("ASYNC", Dir("run"), log(), Dir("audit"));
}

TEST_F(TrainTest, SigtermEndsTheRunWithinTwoSecondsAndSavesThePolicy) {
  Program train("cairn", SmallRun(Dir("run"), 100000000), log());
  ASSERT_TRUE(WaitForTraining(Dir("run"), train)) << ReadFile(log());
  const TimePoint start = Clock::now();
  kill(train.pid(), SIGTERM);
  EXPECT_NE(train.Wait(), 0);
  EXPECT_LT(SecondsSince(start), 2.5);
  EXPECT_TRUE(std::filesystem::exists(Dir("run") / "checkpoints" / "last.policy"));
  EXPECT_EQ(ReadJson(Dir("run") / "summary.json")["completed"], false);
}

bool HasCheckpoint(const std::filesystem::path& run_dir) {
  const auto is_one = [](const auto& entry) { return entry.path().extension() == ".ckpt"; };
  const std::filesystem::directory_iterator files(run_dir / "checkpoints");
  return std::any_of(begin(files), end(files), is_one);
}

// Half a second or more a round.
TEST_F(TrainTest, AStoppedRunReachesACheckpointThoughItsRoundsAreLong) {
  Program train("cairn",
                SmallRun(Dir("run"), 100000000,
                         {"--set", "lockstep.round_steps=20", "--set", "learner.net_arch=[256, 256]", "--set",
                          "learner.batch_size=1024", "--set", "learner.checkpoint_interval_s=1000"}),
                log());
  ASSERT_TRUE(WaitUntil(train, [this] {
    const std::string episodes = ReadFile(Dir("run") / "episodes.csv");
    return std::count(episodes.begin(), episodes.end(), '\n') > 100;
  })) << ReadFile(log());
  kill(train.pid(), SIGTERM);
  EXPECT_EQ(train.Wait(), 128 + SIGTERM);
  EXPECT_TRUE(HasCheckpoint(Dir("run")));
  EXPECT_THAT(ReadFile(Dir("run") / "log" / "launcher.log"), HasSubstr("go on with: cairn train --resume"));
}

TEST_F(TrainTest, WhatIsSaidOfAStoppedRunIsTrue) {
  Program train("cairn", SmallRun(Dir("run"), 100000000), log());
  ASSERT_TRUE(WaitUntil(train, [this] { return std::filesystem::exists(Dir("run") / "run.json"); }));
  kill(train.pid(), SIGTERM);
  EXPECT_EQ(train.Wait(), 128 + SIGTERM);
  EXPECT_THAT(
      ReadFile(Dir("run") / "log" / "launcher.log"),
      HasSubstr(HasCheckpoint(Dir("run")) ? "go on with: cairn train --resume" : "there is nothing to go on from"));
}

std::vector<std::string> ResumableRun(const std::filesystem::path& run, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"--set", "learner.checkpoint_interval_s=0.1", "--set",
                                     "evaluation.interval_env_steps=5000"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return SmallRun(run, 80000, arguments);
}

TEST_F(TrainTest, AStoppedOrKilledLockstepRunGoesOnWithTheSameBits) {
  ASSERT_EQ(RunCairn(ResumableRun(Dir("whole")), log()), 0) << ReadFile(log());
  const nlohmann::json whole = ReadJson(Dir("whole") / "summary.json");
  const std::string episodes = EpisodesWithoutTime(Dir("whole"));
  const struct {
    const char* name;
    const char* process;
    int signal;
    const char* actors;
  } cases[] = {{"stopped", "", SIGTERM, "1"}, {"killed", "cairn-learner", SIGKILL, "2"}, {"dead", "", SIGKILL, "2"}};
  for (const auto& c : cases) {
    {
      Program train("cairn", ResumableRun(Dir(c.name), {"--actors", "1", "--max-restarts", "0"}), log());
      ASSERT_TRUE(WaitForCheckpoint(Dir(c.name), train)) << ReadFile(log());
      kill(*c.process == 0 ? train.pid() : Descendants(train.pid(), c.process).at(0), c.signal);
      EXPECT_NE(train.Wait(), 0);
    }
    ASSERT_EQ(RunCairn({"train", "--resume", Dir(c.name).string(), "--actors", c.actors, "--quiet"}, log()), 0)
        << c.name << ReadFile(log());
    const nlohmann::json summary = ReadJson(Dir(c.name) / "summary.json");
    EXPECT_EQ(summary["weights_crc32c"], whole["weights_crc32c"]) << c.name;
    EXPECT_EQ(summary["eval_steps"], whole["eval_steps"]) << c.name;
    EXPECT_EQ(summary["deterministic"], true) << c.name;
    EXPECT_EQ(summary["transitions_lost"], 0) << c.name;
    EXPECT_EQ(EpisodesWithoutTime(Dir(c.name)), episodes) << c.name;
    if (c.signal == SIGTERM) {
      EXPECT_EQ(summary["transitions_rolled_back"], 0);
    }
  }
}

TEST_F(TrainTest, AStoppedAsyncRunGoesOnInBalanceAndEndsExactly) {
  {
    Program train("cairn", ResumableRun(Dir("run"), {"--set", "schedule=ASYNC", "--actors", "2"}), log());
    ASSERT_TRUE(WaitForTraining(Dir("run"), train)) << ReadFile(log());
    kill(train.pid(), SIGTERM);
    train.Wait();
  }
  const nlohmann::json stopped = ReadJson(Dir("run") / "summary.json");
  EXPECT_EQ(stopped["updates"], std::max<int64_t>(0, stopped["env_steps"].get<int64_t>() - 500) / 10)
      << "nothing is left that a resumed run would make in a burst";
  ASSERT_EQ(RunCairn({"train", "--resume", Dir("run").string(), "--quiet"}, log()), 0) << ReadFile(log());
  const nlohmann::json summary = ReadJson(Dir("run") / "summary.json");
  EXPECT_EQ(summary["env_steps"], 80000);
  EXPECT_EQ(summary["updates"], (80000 - 500) / 10);
  EXPECT_EQ(summary["transitions_lost"], 0);
}

TEST_F(TrainTest, WhatCannotBeResumedIsRefusedByName) {
  EXPECT_EQ(RunCairn({"train", "--resume", Dir("none").string()}, Dir("none.log")), 2);
  EXPECT_THAT(ReadFile(Dir("none.log")), HasSubstr("there is no such directory"));
  ASSERT_EQ(RunCairn(SmallRun(Dir("run"), 1500), log()), 0) << ReadFile(log());
  EXPECT_EQ(RunCairn({"train", "--resume", Dir("run").string()}, Dir("complete.log")), 2);
  EXPECT_THAT(ReadFile(Dir("complete.log")), HasSubstr("the run is complete"));
  EXPECT_EQ(RunCairn({"train", "--resume", Dir("run").string(), "--seed", "3"}, Dir("seed.log")), 2);
  EXPECT_THAT(ReadFile(Dir("seed.log")), HasSubstr("--set or --seed does not go with it"));
  // A larger total lets it go on, another network does not fit.
  const auto edit = [&](const std::string& from, const std::string& to) {
    std::string text = ReadFile(Dir("run") / "experiment.textproto");
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << text;
    std::ofstream(Dir("run") / "experiment.textproto") << text.replace(at, from.size(), to);
  };
  edit("total_env_steps: 1500", "total_env_steps: 2000");
  ASSERT_EQ(RunCairn({"train", "--resume", Dir("run").string(), "--quiet"}, log()), 0) << ReadFile(log());
  EXPECT_EQ(ReadJson(Dir("run") / "summary.json")["env_steps"], 2000);
  edit("total_env_steps: 2000", "total_env_steps: 3000");
  edit("net_arch: [64, 64]", "net_arch: [64, 32]");
  EXPECT_EQ(RunCairn({"train", "--resume", Dir("run").string(), "--quiet"}, Dir("shape.log")), 2);
  EXPECT_THAT(ReadFile(Dir("shape.log")), HasSubstr("learner.net_arch is [64, 64] there, [64, 32] here"));
  // Nor do rows of another size; what would not fit is still there when it is taken back.
  edit("net_arch: [64, 32]", "net_arch: [64, 64]");
  edit("rays: true", "rays: false");
  EXPECT_EQ(RunCairn({"train", "--resume", Dir("run").string(), "--quiet"}, Dir("rays.log")), 2);
  EXPECT_THAT(ReadFile(Dir("rays.log")), HasSubstr("observation size is "));
  edit("rays: false", "rays: true");
  ASSERT_EQ(RunCairn({"train", "--resume", Dir("run").string(), "--quiet"}, log()), 0) << ReadFile(log());
}

TEST_F(TrainTest, InitFromTakesTheNetworksOfAnotherRun) {
  ASSERT_EQ(RunCairn(SmallRun(Dir("first"), 1500), log()), 0) << ReadFile(log());
  const std::string init = "learner.init_from=" + Dir("first").string();
  // Without an update the weights stay those of the first run.
  ASSERT_EQ(RunCairn(SmallRun(Dir("second"), 600, {"--set", init, "--set", "learner.learning_starts=10000"}), log()), 0)
      << ReadFile(log());
  EXPECT_EQ(ReadJson(Dir("second") / "summary.json")["weights_crc32c"],
            ReadJson(Dir("first") / "summary.json")["weights_crc32c"]);
  EXPECT_EQ(RunCairn(SmallRun(Dir("third"), 600, {"--set", init, "--set", "learner.layer_norm=true"}), log()), 2);
  EXPECT_THAT(ReadFile(log()), HasSubstr("learner.layer_norm is false there, true here"));
}

TEST_F(TrainTest, NoProcessIsLeftWhenTheLauncherIsKilled) {
  Program train("cairn", SmallRun(Dir("run"), 100000000, {"--actors", "1"}), log());
  ASSERT_TRUE(WaitForTraining(Dir("run"), train)) << ReadFile(log());
  const std::vector<pid_t> children = Descendants(train.pid(), "cairn-");
  ASSERT_EQ(children.size(), 3u);
  std::vector<pollfd> ends;
  for (const pid_t child : children) {
    ends.push_back({static_cast<int>(syscall(SYS_pidfd_open, child, 0)), POLLIN, 0});
  }
  kill(train.pid(), SIGKILL);
  train.Wait();
  for (pollfd& end : ends) {
    EXPECT_GT(poll(&end, 1, 5000), 0) << "a process outlived the launcher";
    close(end.fd);
  }
}

TEST_F(TrainTest, EvalOfARunNeedsNoLearnerAndAgreesWithItsTest) {
  ASSERT_EQ(RunCairn(SmallRun(Dir("run"), 2000), log()), 0) << ReadFile(log());
  ASSERT_EQ(
      RunCairn({"eval", Dir("run").string(), "--json", "--svg", (Dir("run") / "paths.svg").string()}, Dir("eval.json")),
      0)
      << ReadFile(Dir("eval.json"));
  const nlohmann::json eval = ReadJson(Dir("eval.json"));
  const nlohmann::json summary = ReadJson(Dir("run") / "summary.json");
  EXPECT_EQ(eval["trials"], 20);
  EXPECT_EQ(eval["success_rate"], summary["success_rate"]);
  EXPECT_THAT(ReadFile(Dir("run") / "paths.svg"), HasSubstr("</svg>"));
}

TEST_F(TrainTest, BadInputIsOneLineThatNamesIt) {
  EXPECT_EQ(RunCairn(SmallRun(Dir("run"), 100, {"--set", "learner.batchsize=3"}), log()), 2);
  EXPECT_THAT(ReadFile(log()), HasSubstr("batch_size"));
  EXPECT_EQ(RunCairn(SmallRun(Dir("run"), 100, {"--set", "planner.eta=0.5"}), Dir("eta.log")), 2);
  EXPECT_THAT(ReadFile(Dir("eta.log")), HasSubstr("eta"));
  EXPECT_FALSE(std::filesystem::exists(Dir("run") / "summary.json"));
}

}  // namespace
}  // namespace cairn::testing
