// Whole runs over real processes and LCM, small ones: what they promise about accounting, determinism and failure.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <set>

#include "common/core/clock.h"
#include "tests/integration/run_cairn.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;

const std::string kExperiments = std::string(CAIRN_SOURCE_DIR) + "/deploy/experiments/";

// A fast small run: the plane car, few starts.
std::vector<std::string> SmallRun(const std::filesystem::path& run_dir, int64_t steps,
                                  const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"train", kExperiments + "car_maze.textproto", "--run-dir", run_dir.string(),
                                     "--quiet"};
  for (const std::string& set : {std::string("vehicle.kind=PLANE_CAR"), "total_env_steps=" + std::to_string(steps),
                                 std::string("learner.learning_starts=500"), std::string("learner.train_freq=10"),
                                 std::string("evaluation.interval_env_steps=1000"),
                                 std::string("evaluation.max_steps=60"), std::string("evaluation.test_starts=20")}) {
    arguments.insert(arguments.end(), {"--set", set});
  }
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// episodes.csv without its last column, which is wall-clock time.
std::string EpisodesWithoutTime(const std::filesystem::path& run_dir) {
  std::istringstream file(ReadFile(run_dir / "episodes.csv"));
  std::string text;
  for (std::string line; std::getline(file, line);) text += line.substr(0, line.rfind(',')) + "\n";
  return text;
}

// Nothing lost, nothing twice, nothing changed on the way: what replay holds is a part of what the actors made, and,
// without a killed actor, all of it.
void ExpectReplayMatchesActors(const std::filesystem::path& audit, size_t env_steps, bool actor_died) {
  const std::vector<std::string> replay = AuditLines(audit, "learner");
  const std::vector<std::string> made = AuditLines(audit, "actor");
  const std::set<std::string> replay_set(replay.begin(), replay.end());
  const std::multiset<std::string> made_set(made.begin(), made.end());
  EXPECT_EQ(replay.size(), env_steps);
  EXPECT_EQ(replay_set.size(), replay.size()) << "a transition is in replay twice";
  EXPECT_TRUE(std::includes(made_set.begin(), made_set.end(), replay_set.begin(), replay_set.end()));
  if (!actor_died) {
    EXPECT_EQ(made.size(), replay.size()) << "a transition was lost";
  }
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

TEST_F(TrainTest, Td3WithoutOverlapRuns) {
  ASSERT_EQ(RunCairn(SmallRun(Dir("run"), 1500, {"--set", "learner.algorithm=TD3", "--set", "lockstep.overlap=false"}),
                     log()),
            0)
      << ReadFile(log());
  EXPECT_EQ(ReadJson(Dir("run") / "summary.json")["policy_lag_mean"], 0.0);
}

// Waits until a run has written its first episodes, so that it is in the middle of training; no sleep, a bounded wait
// on the launcher's own end.
bool WaitForTraining(const std::filesystem::path& run_dir, const Program& program) {
  const int pidfd = static_cast<int>(syscall(SYS_pidfd_open, program.pid(), 0));
  bool training = false;
  const TimePoint deadline = Clock::now() + std::chrono::seconds(60);
  while (!training && Clock::now() < deadline) {
    pollfd ended{pidfd, POLLIN, 0};
    if (poll(&ended, 1, 10) > 0) break;
    std::error_code error;
    training = std::filesystem::file_size(run_dir / "episodes.csv", error) > 1000 && !error;
  }
  close(pidfd);
  return training;
}

void KillOneActor(const std::string& schedule, const std::filesystem::path& run, const std::filesystem::path& log,
                  const std::filesystem::path& audit) {
  Program train(
      "cairn",
      SmallRun(run, 60000,
               {"--actors", "2", "--set", "schedule=" + schedule, "--set", "evaluation.interval_env_steps=20000"}),
      log, {{"CAIRN_AUDIT_DIR", audit.string()}});
  ASSERT_TRUE(WaitForTraining(run, train)) << ReadFile(log);
  const std::vector<pid_t> actors = Descendants(train.pid(), "cairn-actor");
  ASSERT_EQ(actors.size(), 2u);
  ASSERT_EQ(kill(actors[0], SIGKILL), 0);
  EXPECT_EQ(train.Wait(), 0) << ReadFile(log);
  const nlohmann::json summary = ReadJson(run / "summary.json");
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["env_steps"], 60000);
  EXPECT_EQ(summary["transitions_lost"], 0);
  EXPECT_EQ(summary["deterministic"], false);
  ExpectReplayMatchesActors(audit, 60000, true);
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
