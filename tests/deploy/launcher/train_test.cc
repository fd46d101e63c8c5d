#include "deploy/launcher/train.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/core/check.h"
#include "deploy/launcher/network.h"
#include "tests/deploy/launcher/test_support.h"

// `cairn train` with shell scripts beside it in place of planner, learner and actor.
namespace cairn::deploy {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kCarMaze = CAIRN_SOURCE_DIR "/deploy/experiments/car_maze.textproto";

class TrainTest : public testing::Test {
 protected:
  TrainTest() {
    fs::create_directory(directory_ / "bin");
    fs::copy_file(CAIRN_PROGRAM, directory_ / "bin/cairn");
    Script("planner", Hold("planner"));
    Script("learner", "exit 0");
    Script("actor", Hold("actor"));
  }

  // Tests run side by side, each in a process of its own.
  const int base_port_ = 41800 + 10 * (getpid() % 2000);

  void Script(const std::string& kind, const std::string& body) {
    const std::string file = directory_ / ("bin/cairn-" + kind);
    WriteText(file, "#!/bin/sh\n" + body + "\n");
    chmod(file.c_str(), 0755);
  }

  // Runs until it is told to end, holding a lock by which its death shows.
  std::string Hold(const std::string& name) { return std::string("exec ") + HELPER + " hold " + (directory_ / name); }

  std::vector<std::string> Arguments(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{directory_ / "bin/cairn",
                                       "train",
                                       kCarMaze,
                                       "--run-dir",
                                       directory_ / "run",
                                       "--actors",
                                       "1",
                                       "--set",
                                       "transport.base_port=" + std::to_string(base_port_)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  int Start() { return StartProgram(Arguments(), directory_ / "out", directory_ / "err"); }

  // Two lasting processes open their FIFOs; the launcher is then up.
  void MakeFifos(const std::vector<std::string>& names) {
    for (const std::string& name : names) MakeReadyFifo(directory_ / name);
  }

  TemporaryDirectory directory_;
};

TEST_F(TrainTest, CleanEndOfTheLearnerIsSuccess) {
  const ProgramResult result = RunProgram(Arguments());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, HasSubstr("done in"));
  EXPECT_THAT(ReadText(directory_ / "run/experiment.textproto"), HasSubstr("base_port: " + std::to_string(base_port_)));
}

TEST_F(TrainTest, QuietSaysNothing) {
  const ProgramResult result = RunProgram(Arguments({"--quiet"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out + result.err, "");
}

TEST_F(TrainTest, ProcessesGetTheAgreedCommandLines) {
  Script("learner", "echo \"$@\" > " + (directory_ / "learner.args"));
  const ProgramResult result = RunProgram(Arguments({"--seed", "9"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string arguments = ReadText(directory_ / "learner.args");
  const auto info = nlohmann::json::parse(ReadText(directory_ / "run/run.json"));
  for (const std::string& word :
       {directory_ / "run/experiment.textproto", "--run-dir " + (directory_ / "run"),
        "--run-id " + info.at("run_id").get<std::string>(), "--lcm-url " + info.at("lcm_url").get<std::string>(),
        fmt::format("udpm://239.255.76.67:{}?ttl=0", info.at("base_port").get<int>()), std::string("--parent-fd "),
        std::string("--actors 1"), std::string("--launch-utime-us ")}) {
    EXPECT_THAT(arguments, HasSubstr(word));
  }
  EXPECT_THAT(ReadText(directory_ / "run/experiment.textproto"), HasSubstr("\nseed: 9\n"));
  EXPECT_THAT(arguments, testing::Not(HasSubstr("--key")));
  EXPECT_FALSE(fs::exists(directory_ / "run/key"));
}

// With ttl 1 there is no private network to fall back to: in one of the test's own.
class OtherHostsTest : public TrainTest {
 protected:
  ProgramResult Train(const std::vector<std::string>& arguments) {
    const std::string out = directory_ / "out", err = directory_ / "err";
    ProgramResult result;
    result.exit_code = InChildProcess([&] {
      try {
        EnterPrivateNetwork("239.255.76.67");
      } catch (const Error&) {
        return kNotAllowed;
      }
      return WaitForProgram(StartProgram(arguments, out, err));
    });
    if (result.exit_code != kNotAllowed) result.out = ReadText(out), result.err = ReadText(err);
    return result;
  }

  std::string RunId() { return nlohmann::json::parse(ReadText(directory_ / "run/run.json")).at("run_id"); }
};

TEST_F(OtherHostsTest, RunMakesAKeyForAllItsProcessesAndSaysHowToJoin) {
  Script("learner", "echo \"$@\" > " + (directory_ / "learner.args"));
  const ProgramResult result = Train(Arguments({"--set", "transport.ttl=1"}));
  if (result.exit_code == kNotAllowed) GTEST_SKIP() << "no private network";
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string key = directory_ / "run/key";
  EXPECT_EQ(fs::status(key).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_THAT(ReadText(directory_ / "learner.args"), HasSubstr("--key " + key));
  EXPECT_THAT(result.out, HasSubstr("experiment.textproto and key"));
  EXPECT_THAT(result.out, HasSubstr(fmt::format("cairn actor experiment.textproto --lcm-url "
                                                "'udpm://239.255.76.67:{}?ttl=1' --run-id {} --key key --actor-id N",
                                                base_port_, RunId())));
}

TEST_F(OtherHostsTest, ResumedRunKeepsItsKeyUnderANewId) {
  const ProgramResult first = Train(Arguments({"--set", "transport.ttl=1"}));
  if (first.exit_code == kNotAllowed) GTEST_SKIP() << "no private network";
  const std::string key = ReadText(directory_ / "run/key"), run_id = RunId();
  WriteText(directory_ / "run/checkpoints/checkpoint-1.ckpt", "");
  Script("learner", "echo \"$@\" > " + (directory_ / "learner.args"));
  const ProgramResult again =
      Train({directory_ / "bin/cairn", "train", "--resume", directory_ / "run", "--actors", "1"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(ReadText(directory_ / "run/key"), key);
  EXPECT_NE(RunId(), run_id);
  EXPECT_THAT(ReadText(directory_ / "learner.args"), HasSubstr("--key " + (directory_ / "run/key")));
}

TEST_F(OtherHostsTest, InsecureMakesNoKeyAndSaysSo) {
  Script("learner", "echo \"$@\" > " + (directory_ / "learner.args"));
  const ProgramResult result = Train(Arguments({"--set", "transport.ttl=1", "--insecure"}));
  if (result.exit_code == kNotAllowed) GTEST_SKIP() << "no private network";
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_FALSE(fs::exists(directory_ / "run/key"));
  EXPECT_THAT(ReadText(directory_ / "learner.args"), HasSubstr("--insecure"));
  EXPECT_THAT(result.out, HasSubstr("no key: whoever can send"));
}

TEST_F(TrainTest, FailedLearnerIsOneLineWithItsLastErrorAndLog) {
  Script("learner", "echo 'cairn-learner: error: critic_loss is not finite' >&2; exit 1");
  const ProgramResult result = RunProgram(Arguments());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.err, "cairn: error: learner failed (exit code 1): critic_loss is not finite; see " +
                            (directory_ / "run/log/learner.log\n"));
}

TEST_F(TrainTest, RefusedInputOfAProcessExitsTwo) {
  Script("planner", "echo 'cairn-planner: error: planner.eta = 0.2 m: too large' >&2; exit 2");
  Script("learner", Hold("learner"));
  const ProgramResult result = RunProgram(Arguments());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("planner.eta = 0.2 m: too large"));
}

TEST_F(TrainTest, MissingProgramLeavesNoRunDirectory) {
  fs::remove(directory_ / "bin/cairn-learner");
  const ProgramResult result = RunProgram(Arguments());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("cairn-learner"));
  EXPECT_FALSE(fs::exists(directory_ / "run"));
}

TEST_F(TrainTest, DeadActorIsReplacedAndTheRunSucceeds) {
  // The actor's first process dies; the learner ends when the second has started.
  MakeFifos({"learner"});
  Script("actor", "case \"$*\" in *'--generation 0') kill -9 $$ ;; esac; cat " + (directory_ / "learner.ready"));
  Script("learner", "echo go > " + (directory_ / "learner.ready"));
  const ProgramResult result = RunProgram(Arguments());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("actor-0 ended (killed by SIGKILL); starting it again, generation 1"));
  EXPECT_THAT(result.out, HasSubstr("1 restart"));
}

TEST_F(TrainTest, TermStopsAllProcesses) {
  MakeFifos({"planner", "learner", "actor"});
  Script("learner", Hold("learner"));
  const int cairn = Start();
  for (const char* name : {"planner", "learner", "actor"}) WaitUntilHeld(directory_ / name);
  kill(cairn, SIGTERM);
  EXPECT_EQ(WaitForProgram(cairn), 128 + SIGTERM) << ReadText(directory_ / "err");
  for (const char* name : {"planner", "learner", "actor"}) WaitUntilReleased(directory_ / name);
  EXPECT_THAT(ReadText(directory_ / "out"), HasSubstr("stopped"));
}

TEST_F(TrainTest, KilledLauncherTakesAllProcessesWithIt) {
  MakeFifos({"planner", "learner", "actor"});
  Script("learner", Hold("learner"));
  const int cairn = Start();
  for (const char* name : {"planner", "learner", "actor"}) WaitUntilHeld(directory_ / name);
  kill(cairn, SIGKILL);
  WaitForProgram(cairn);
  for (const char* name : {"planner", "learner", "actor"}) WaitUntilReleased(directory_ / name);
}

TEST_F(TrainTest, SecondRunTakesTheNextPorts) {
  MakeFifos({"planner", "learner", "actor"});
  Script("learner", Hold("learner"));
  const int first = Start();
  for (const char* name : {"planner", "learner", "actor"}) WaitUntilHeld(directory_ / name);
  Script("learner", "exit 0");
  std::vector<std::string> arguments = Arguments();
  arguments[4] = directory_ / "run2";
  const ProgramResult second = RunProgram(arguments);
  kill(first, SIGTERM);
  WaitForProgram(first);
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_THAT(second.out,
              HasSubstr(fmt::format("UDP ports from {} on are taken; using {}", base_port_, base_port_ + 5)));
}

}  // namespace
}  // namespace cairn::deploy
