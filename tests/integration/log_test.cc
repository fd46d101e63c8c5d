// `cairn log`, LCM's own player, and training from what was recorded.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <memory>

#include "common/bus/log_file.h"
#include "common/core/check.h"
#include "tests/integration/run_cairn.h"

namespace cairn::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

class RecordedRunTest : public ::testing::Test {
 protected:
  std::filesystem::path Dir(const std::string& name) const { return directory_.path() / name; }

  // Starts `cairn log` and waits until it listens.
  std::unique_ptr<Program> Record(const std::string& name, int port, const std::string& planes) const {
    auto log = std::make_unique<Program>(
        "cairn",
        std::vector<std::string>{"log", "--lcm-url", "udpm://239.255.76.67:" + std::to_string(port), "--planes", planes,
                                 "--out", Dir(name).string()},
        Dir(name + ".out"));
    EXPECT_TRUE(WaitUntil(
        *log, [&] { return ReadFile(Dir(name + ".out")).find("recording") != std::string::npos; }, seconds(20)))
        << ReadFile(Dir(name + ".out"));
    return log;
  }

  void End(Program* log, const std::string& name) const {
    kill(log->pid(), SIGINT);
    EXPECT_EQ(log->Wait(), 0) << ReadFile(Dir(name + ".out"));
    EXPECT_THAT(ReadFile(Dir(name + ".out")), HasSubstr("nothing dropped"));
  }

  // A run of 3000 steps with its experience in `name`; the private network of the test is its own.
  void RunRecorded(const std::string& name, const std::vector<std::string>& more = {}) const {
    const auto log = Record(name, 7700, "experience");
    std::vector<std::string> all{"--actors", "2"};
    all.insert(all.end(), more.begin(), more.end());
    ASSERT_EQ(RunCairn(SmallRun(Dir(name + "-run"), 3000, all), Dir("run.log")), 0) << ReadFile(Dir("run.log"));
    End(log.get(), name);
  }

  std::vector<LoggedMessage> Read(const std::string& name) const {
    LogReader reader(Dir(name).string());
    std::vector<LoggedMessage> all;
    while (std::optional<LoggedMessage> m = reader.Next()) all.push_back(std::move(*m));
    EXPECT_EQ(reader.faults(), 0);
    return all;
  }

  // Trains from a log; the exit status.
  int Replay(const std::string& run, const std::string& log, int64_t steps,
             const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{"--actors", "1", "--replay-log", Dir(log).string()};
    all.insert(all.end(), more.begin(), more.end());
    return RunCairn(SmallRun(Dir(run), steps, all), Dir(run + ".log"));
  }

  nlohmann::json Summary(const std::string& run) const { return ReadJson(Dir(run) / "summary.json"); }

  TemporaryDirectory directory_;
};

TEST_F(RecordedRunTest, LcmPlaysItBackToTheSameCountsAndBytes) {
  if (!std::filesystem::exists("/usr/bin/lcm-logplayer")) GTEST_SKIP() << "no lcm-logplayer (liblcm-bin)";
  RunRecorded("a");
  const auto log = Record("b", 23500, "experience");
  Program player("/usr/bin/lcm-logplayer", {"-l", "udpm://239.255.76.67:23500?ttl=0", "-s", "2", Dir("a").string()},
                 Dir("player.out"));
  ASSERT_EQ(player.Wait(), 0) << ReadFile(Dir("player.out"));
  const std::vector<LoggedMessage> a = Read("a");
  ASSERT_GT(a.size(), 10u);
  // The last ones may still be in the sockets.
  EXPECT_TRUE(WaitUntil(*log, [&] {
    LogReader reader(Dir("b").string());
    size_t count = 0;
    while (reader.Next()) ++count;
    return count >= a.size();
  }));
  End(log.get(), "b");
  const std::vector<LoggedMessage> b = Read("b");
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].channel, b[i].channel);
    EXPECT_EQ(a[i].bytes, b[i].bytes) << i;
  }
}

TEST_F(RecordedRunTest, ALearnerIsFedFromItWithAllThatTheRunMadeAndTheSameBitsEachTime) {
  RunRecorded("a");
  for (const std::string run : {"first", "second"}) {
    std::filesystem::create_directories(Dir(run + "-audit"));
    std::vector<std::string> arguments =
        SmallRun(Dir(run), 10000, {"--actors", "1", "--replay-log", Dir("a").string()});
    ASSERT_EQ(RunCairn(arguments, Dir(run + ".log"), {{"CAIRN_AUDIT_DIR", Dir(run + "-audit").string()}}), 0)
        << ReadFile(Dir(run + ".log"));
  }
  const nlohmann::json first = Summary("first");
  EXPECT_EQ(first["completed"], true);  // with the end of the log
  EXPECT_EQ(first["env_steps"], 3000);
  EXPECT_EQ(first["updates"], 250);  // (3000 - 500) / 10
  EXPECT_EQ(first["trials"], 20);
  EXPECT_EQ(first["replay_log"]["transitions"], 3000);
  EXPECT_EQ(first["replay_log"]["messages_missing"], 0);
  EXPECT_EQ(first["replay_log"]["faults"], 0);
  EXPECT_EQ(first["weights_crc32c"], Summary("second")["weights_crc32c"]);
  EXPECT_EQ(AuditLines(Dir("first-audit"), "learner").size(), 3000u);
  EXPECT_EQ(AuditLines(Dir("first-audit"), "learner"), AuditLines(Dir("second-audit"), "learner"));
  // What was recorded goes on as a run like any other.
  ASSERT_EQ(RunCairn({"train", "--resume", Dir("first").string(), "--actors", "2"}, Dir("resume.log")), 0)
      << ReadFile(Dir("resume.log"));
  EXPECT_EQ(Summary("first")["env_steps"], 10000);
  EXPECT_EQ(Summary("first")["transitions_lost"], 0);
}

TEST_F(RecordedRunTest, StopsExactlyAtTotalEnvSteps) {
  RunRecorded("a");
  ASSERT_EQ(Replay("run", "a", 1501), 0) << ReadFile(Dir("run.log"));
  EXPECT_EQ(Summary("run")["env_steps"], 1501);
}

TEST_F(RecordedRunTest, TornAndDirtyLogsAreCountedAndSaidOnce) {
  RunRecorded("a");
  const std::string whole = ReadFile(Dir("a"));
  std::ofstream(Dir("torn"), std::ios::binary) << "garbage" << whole.substr(0, whole.size() * 2 / 3);
  ASSERT_EQ(Replay("run", "torn", 10000), 0) << ReadFile(Dir("run.log"));
  const nlohmann::json summary = Summary("run");
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["replay_log"]["faults"], 2);
  EXPECT_GT(summary["env_steps"], 1000);
  EXPECT_LT(summary["env_steps"], 3000);
  EXPECT_THAT(ReadFile(Dir("run") / "log" / "learner.log"), HasSubstr("2 places that are no message"));
}

TEST_F(RecordedRunTest, WhatCannotFeedThisExperimentIsRefusedByName) {
  RunRecorded("a");
  EXPECT_EQ(Replay("rays", "a", 1000, {"--set", "vehicle.scan.beams=8"}), 2);
  EXPECT_THAT(ReadFile(Dir("rays.log")),
              HasSubstr("it was recorded from another experiment: observation_size 25 (here 17)"));
  std::ofstream(Dir("nothing"), std::ios::binary) << "no log at all";
  EXPECT_EQ(Replay("nothing-run", "nothing", 1000), 2);
  EXPECT_THAT(ReadFile(Dir("nothing-run.log")), HasSubstr("it holds no experience"));
  EXPECT_EQ(Replay("absent-run", "absent", 1000), 2);
  EXPECT_THAT(ReadFile(Dir("absent-run.log")), HasSubstr("No such file"));
  EXPECT_FALSE(std::filesystem::exists(Dir("absent-run")));
}

TEST_F(RecordedRunTest, ASealedLogNeedsItsKey) {
  RunRecorded("a", {"--set", "transport.ttl=1"});
  EXPECT_EQ(Replay("bare", "a", 1000), 2);
  EXPECT_THAT(ReadFile(Dir("bare.log")), HasSubstr("sealed with a key; give --replay-key FILE"));
  ASSERT_EQ(Replay("keyed", "a", 10000, {"--replay-key", (Dir("a-run") / "key").string()}), 0)
      << ReadFile(Dir("keyed.log"));
  EXPECT_EQ(Summary("keyed")["env_steps"], 3000);
}

}  // namespace
}  // namespace cairn::testing
