#include "deploy/launcher/child.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "common/core/check.h"
#include "tests/deploy/launcher/test_support.h"

namespace cairn::deploy {
namespace {

using testing::HasSubstr;

class ChildTest : public testing::Test {
 protected:
  Command HelperCommand(std::vector<std::string> arguments) {
    return {"helper", HELPER, std::move(arguments), directory_ / "log"};
  }

  // Runs a helper to its end and returns its end in words.
  std::string Run(std::vector<std::string> arguments, int parent_fd = -1) {
    Child child(HelperCommand(std::move(arguments)), parent_fd);
    siginfo_t info;
    waitid(P_PID, static_cast<id_t>(child.pid()), &info, WEXITED | WNOWAIT);
    return DescribeStatus(*child.Poll());
  }

  TemporaryDirectory directory_;
};

TEST_F(ChildTest, TellsExitCodeAndSignalInWords) {
  EXPECT_EQ(Run({"exit", "3"}), "exit code 3");
  EXPECT_EQ(Run({"crash"}), "crashed with SIGABRT");
}

TEST_F(ChildTest, OutputIsAppendedToTheLog) {
  Run({"exit", "0", "first"});
  Run({"exit", "0", "second"});
  EXPECT_EQ(ReadText(directory_ / "log"), "first\nsecond\n");
}

TEST_F(ChildTest, MissingProgramIsNamed) {
  try {
    Child({"learner", "/nonexistent/cairn-learner", {}, directory_ / "log"}, -1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "cannot start learner (/nonexistent/cairn-learner): No such file or directory");
  }
}

TEST_F(ChildTest, LogThatCannotBeOpenedIsNamed) {
  EXPECT_THROW(Child({"learner", HELPER, {}, directory_ / "no/such/log"}, -1), Error);
}

TEST_F(ChildTest, InheritsTheParentsPipeAndNothingElse) {
  int pipe_fds[2], other[2];
  ASSERT_EQ(pipe(pipe_fds), 0);
  ASSERT_EQ(pipe(other), 0);
  Run({"fds"}, pipe_fds[0]);
  EXPECT_EQ(ReadText(directory_ / "log"), fmt::format("fd 0\nfd 1\nfd 2\nfd {}\n", pipe_fds[0]));
  for (const int fd : {pipe_fds[0], pipe_fds[1], other[0], other[1]}) close(fd);
}

TEST_F(ChildTest, LeadsAProcessGroup) {
  Run({"group"});
  EXPECT_EQ(ReadText(directory_ / "log"), "leads its group: 1\n");
}

TEST_F(ChildTest, SignalsReachItUntilItHasEnded) {
  const std::string file = directory_ / "lock";
  MakeReadyFifo(file);
  Child child(HelperCommand({"hold", file}), -1);
  EXPECT_EQ(WaitUntilHeld(file), child.pid());
  EXPECT_FALSE(child.Poll().has_value());
  child.Signal(SIGTERM);
  WaitUntilReleased(file);
  siginfo_t info;
  waitid(P_PID, static_cast<id_t>(child.pid()), &info, WEXITED | WNOWAIT);
  EXPECT_EQ(DescribeStatus(*child.Poll()), "killed by SIGTERM");
  child.Signal(SIGTERM);
}

TEST_F(ChildTest, LastErrorLineIsTheNewestThatTellsOfOne) {
  const std::string log = directory_ / "log";
  EXPECT_EQ(LastErrorLine(log), "");
  WriteText(log, "a\nlearner info: start\n\n");
  EXPECT_EQ(LastErrorLine(log), "") << "no cause of anything";
  WriteText(log, "x error: one\ny error: two\nbye\n");
  EXPECT_EQ(LastErrorLine(log), "y error: two");
  WriteText(log, "x error: early\n" + std::string(100000, 'z') + "\nend\n");
  EXPECT_EQ(LastErrorLine(log), "end");
}

}  // namespace
}  // namespace cairn::deploy
