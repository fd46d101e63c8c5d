#include "deploy/launcher/supervisor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>

#include "common/core/check.h"
#include "tests/deploy/launcher/test_support.h"

namespace cairn::deploy {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class SupervisorTest : public testing::Test {
 protected:
  SupervisorTest() {
    config_.kill_after = std::chrono::seconds(20);  // longer than a helper ever takes on SIGTERM
    config_.tick_period = std::chrono::milliseconds(1);
    config_.note = [this](const std::string& line) { notes_.push_back(line); };
  }

  void Make() { supervisor_ = std::make_unique<Supervisor>(&signals_, config_); }

  void Add(const std::string& name, Role role, std::vector<std::string> arguments) {
    const Command command{name, HELPER, std::move(arguments), directory_ / (name + ".log")};
    supervisor_->Add({name, role, [this, name, command](int generation) {
                        generations_.push_back(name + " " + std::to_string(generation));
                        return command;
                      }});
  }

  // Adds a process that lives until it is told to end and holds a lock meanwhile.
  void AddLasting(const std::string& name, Role role, const std::string& mode = "hold") {
    WriteText(directory_ / name, "");
    Add(name, role, {mode, directory_ / name});
  }

  SignalEvents signals_;
  SupervisorConfig config_;
  TemporaryDirectory directory_;
  std::vector<std::string> notes_, generations_;
  std::unique_ptr<Supervisor> supervisor_;
};

TEST_F(SupervisorTest, EndOfTheMainProcessEndsAll) {
  Make();
  AddLasting("planner", Role::kService);
  AddLasting("actor", Role::kWorker);
  Add("learner", Role::kMain, {"exit", "0"});
  const RunEnd end = supervisor_->Run();
  EXPECT_EQ(end.exit_code, 0);
  EXPECT_EQ(end.failure, "");
  WaitUntilReleased(directory_ / "planner");
  WaitUntilReleased(directory_ / "actor");
}

TEST_F(SupervisorTest, WorkerThatDiesIsReplacedWithTheNextGeneration) {
  // The actor's third process succeeds; stop then.
  config_.tick = [this] {
    if (ReadText(directory_ / "starts").size() >= 3) kill(getpid(), SIGTERM);
  };
  Make();
  AddLasting("learner", Role::kMain);
  Add("actor", Role::kWorker, {"count", directory_ / "starts", "3"});
  const RunEnd end = supervisor_->Run();
  EXPECT_EQ(end.exit_code, 128 + SIGTERM);
  EXPECT_EQ(end.restarts, 2);
  EXPECT_EQ(generations_, (std::vector<std::string>{"learner 0", "actor 0", "actor 1", "actor 2"}));
  ASSERT_EQ(notes_.size(), 2u);
  EXPECT_EQ(notes_[0], "actor ended (exit code 1); starting it again, generation 1");
}

TEST_F(SupervisorTest, TooManyRestartsFailTheRun) {
  config_.max_restarts = 3;
  Make();
  AddLasting("learner", Role::kMain);
  Add("actor", Role::kWorker, {"exit", "1", "actor error: no table"});
  const RunEnd end = supervisor_->Run();
  EXPECT_EQ(end.exit_code, 1);
  EXPECT_EQ(end.restarts, 3);
  EXPECT_THAT(end.failure,
              AllOf(HasSubstr("actor"), HasSubstr("3 restarts"), HasSubstr("no table"), HasSubstr("actor.log")));
}

TEST_F(SupervisorTest, DeathOfTheMainProcessIsOneLineWithItsLastError) {
  Make();
  Add("learner", Role::kMain, {"exit", "1", "cairn-learner: error: loss is not finite"});
  const RunEnd end = supervisor_->Run();
  EXPECT_EQ(end.exit_code, 1);
  EXPECT_EQ(end.failure, "learner failed (exit code 1): loss is not finite; see " + (directory_ / "learner.log"));
}

TEST_F(SupervisorTest, AMainProcessThatASignalKilledIsReplaced) {
  Make();
  Add("learner", Role::kMain, {"die", directory_ / "starts", "3"});
  const RunEnd end = supervisor_->Run();
  EXPECT_EQ(end.exit_code, 0) << end.failure;
  EXPECT_EQ(end.restarts, 2);
  ASSERT_EQ(notes_.size(), 2u);
  EXPECT_EQ(notes_[0], "learner ended (killed by SIGKILL); starting it again, generation 1");
}

TEST_F(SupervisorTest, AServiceIsReplacedHoweverItEnded) {
  config_.max_restarts = 2;
  Make();
  AddLasting("learner", Role::kMain);
  Add("planner", Role::kService, {"exit", "0"});
  const RunEnd end = supervisor_->Run();
  EXPECT_EQ(end.exit_code, 1);
  EXPECT_EQ(end.restarts, 2);
  EXPECT_THAT(end.failure, HasSubstr("planner failed after 2 restarts within a minute (exit code 0)"));
}

TEST_F(SupervisorTest, WithoutRestartsTheFirstDeathEndsTheRun) {
  config_.max_restarts = 0;
  Make();
  Add("learner", Role::kMain, {"die", directory_ / "starts", "3"});
  const RunEnd end = supervisor_->Run();
  EXPECT_EQ(end.exit_code, 1);
  EXPECT_EQ(end.restarts, 0);
  EXPECT_THAT(end.failure, HasSubstr("learner failed (killed by SIGKILL"));
}

TEST_F(SupervisorTest, RefusedInputIsAUsageErrorAndNotTriedAgain) {
  Make();
  AddLasting("learner", Role::kMain);
  Add("actor", Role::kWorker, {"exit", "2", "cairn-actor: error: vehicle too long"});
  const RunEnd end = supervisor_->Run();
  EXPECT_EQ(end.exit_code, 2);
  EXPECT_EQ(end.restarts, 0);
  EXPECT_THAT(end.failure, HasSubstr("vehicle too long"));
}

// As under nohup.
TEST(SignalEventsTest, WhatWasIgnoredAtTheStartStaysIgnored) {
  std::signal(SIGHUP, SIG_IGN);
  {
    SignalEvents signals;
    raise(SIGHUP);
    EXPECT_EQ(signals.Wait(Duration::zero()), 0);
    raise(SIGTERM);
    EXPECT_EQ(signals.Wait(Duration::zero()), SIGTERM);
  }
  std::signal(SIGHUP, SIG_DFL);
}

TEST_F(SupervisorTest, StubbornProcessIsKilledAfterTheDeadline) {
  config_.kill_after = std::chrono::milliseconds(1);
  Make();
  const std::string file = directory_ / "actor";
  MakeReadyFifo(file);
  Add("actor", Role::kWorker, {"stubborn", file});
  const int waiter = fork();
  if (waiter == 0) {
    WaitUntilHeld(file);
    kill(getppid(), SIGINT);
    _exit(0);
  }
  EXPECT_EQ(supervisor_->Run().exit_code, 128 + SIGINT);
  WaitUntilReleased(file);
  WaitForProgram(waiter);
}

TEST_F(SupervisorTest, ProcessThatCannotStartStopsTheOthers) {
  Make();
  AddLasting("planner", Role::kService);
  supervisor_->Add({"learner", Role::kMain, [this](int) {
                      return Command{"learner", "/nonexistent/x", {}, directory_ / "learner.log"};
                    }});
  EXPECT_THROW(supervisor_->Run(), Error);
  supervisor_.reset();
}

// The launcher is killed, so it can do nothing more: the kernel ends processes 0 to 2, and process 3, which has
// switched the kernel's signal off, by the end of file on its pipe.
TEST_F(SupervisorTest, NoProcessOutlivesAKilledLauncher) {
  std::vector<std::string> files;
  for (int i = 0; i < 4; ++i) {
    files.push_back(directory_ / std::to_string(i));
    MakeReadyFifo(files.back());
  }
  const int launcher = StartProgram({HELPER, "supervise", directory_.path()}, directory_ / "out", directory_ / "err");
  for (const std::string& file : files) EXPECT_GT(WaitUntilHeld(file), 0);
  kill(launcher, SIGKILL);
  EXPECT_EQ(WaitForProgram(launcher), 128 + SIGKILL);
  for (const std::string& file : files) WaitUntilReleased(file);
}

TEST_F(SupervisorTest, NoProcessOutlivesAStoppedLauncher) {
  std::vector<std::string> files;
  for (int i = 0; i < 4; ++i) {
    files.push_back(directory_ / std::to_string(i));
    MakeReadyFifo(files.back());
  }
  const int launcher = StartProgram({HELPER, "supervise", directory_.path()}, directory_ / "out", directory_ / "err");
  for (const std::string& file : files) EXPECT_GT(WaitUntilHeld(file), 0);
  kill(launcher, SIGTERM);
  EXPECT_EQ(WaitForProgram(launcher), 128 + SIGTERM);
  for (const std::string& file : files) WaitUntilReleased(file);
}

}  // namespace
}  // namespace cairn::deploy
