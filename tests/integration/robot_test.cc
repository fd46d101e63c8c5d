#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include "tests/integration/run_cairn.h"

namespace cairn::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

// `cairn robot` and `cairn drive` on a trained run, as two processes that know of each other by their messages alone.
class RobotTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    directory_ = std::make_unique<TemporaryDirectory>();
    ASSERT_EQ(RunCairn(SmallRun(Dir("run"), 40000,
                                {"--set", "learner.train_freq=4", "--set", "evaluation.interval_env_steps=10000",
                                 "--set", "evaluation.max_steps=300"}),
                       Dir("log")),
              0)
        << ReadFile(Dir("log"));
  }
  static void TearDownTestSuite() { directory_.reset(); }

  static std::filesystem::path Dir(const std::string& name) { return directory_->path() / name; }

  static std::unique_ptr<Program> Start(std::vector<std::string> arguments, const std::string& log) {
    std::filesystem::remove(Dir(log));
    arguments.insert(arguments.begin() + 1, Dir("run").string());
    return std::make_unique<Program>("cairn", arguments, Dir(log));
  }

  static inline std::unique_ptr<TemporaryDirectory> directory_;
};

TEST_F(RobotTest, MostTripsArrive) {
  int arrived = 0;
  for (int trial = 0; trial < 6; ++trial) {
    const auto robot = Start({"robot", "--speed", "0", "--trial", std::to_string(trial)}, "robot.log");
    const auto drive = Start({"drive", "--timeout", "60"}, "drive.log");
    const std::optional<int> end = robot->WaitFor(seconds(60));
    ASSERT_TRUE(end) << ReadFile(Dir("robot.log")) << ReadFile(Dir("drive.log"));
    if (*end != 0) {
      EXPECT_THAT(ReadFile(Dir("robot.log")), ::testing::ContainsRegex("error: (touched something|ended) at"));
      continue;
    }
    EXPECT_EQ(drive->WaitFor(seconds(20)), 0) << ReadFile(Dir("drive.log"));
    EXPECT_THAT(ReadFile(Dir("robot.log")), HasSubstr("reached the goal at"));
    EXPECT_THAT(ReadFile(Dir("drive.log")), HasSubstr("arrived after"));
    ++arrived;
  }
  EXPECT_GE(arrived, 3);
}

// The robot stops by itself when its driver is gone, and goes on with the next one.
TEST_F(RobotTest, TheRobotStandsStillWithoutItsDriverAndGoesOnWithTheNext) {
  const auto robot = Start({"robot", "--speed", "0.5"}, "robot.log");
  const auto first = Start({"drive"}, "drive.log");
  ASSERT_TRUE(WaitUntil(*robot, [] { return ReadFile(Dir("drive.log")).find("m to go") != std::string::npos; }));
  kill(first->pid(), SIGKILL);
  first->Wait();
  EXPECT_TRUE(WaitUntil(*robot, [] { return ReadFile(Dir("robot.log")).find("standing still") != std::string::npos; }));
  const auto second = Start({"drive"}, "second.log");
  ASSERT_TRUE(WaitUntil(*robot, [] { return ReadFile(Dir("second.log")).find("m to go") != std::string::npos; }));
  kill(second->pid(), SIGINT);
  EXPECT_EQ(second->WaitFor(seconds(10)), 128 + SIGINT);
}

TEST_F(RobotTest, BadInputIsOneLineThatNamesIt) {
  const struct {
    std::vector<std::string> arguments;
    const char* message;
  } cases[] = {{{"drive", "--lcm-url", "tcpq://localhost:7700"}, "a robot is driven by udpm://"},
               {{"drive", "--lcm-url", "udpm://1.2.3.4:7700"}, "--lcm-url udpm://1.2.3.4:7700"},
               {{"drive", "--name", "a b"}, "--name a b"},
               {{"drive", "--set", "vehicle.scan.beams=8"}, "the policy takes 25 observations"},
               {{"robot", "--speed", "-1"}, "--speed"}};
  for (const auto& c : cases) {
    EXPECT_EQ(Start(c.arguments, "bad.log")->WaitFor(seconds(20)), 2) << c.message;
    EXPECT_THAT(ReadFile(Dir("bad.log")), HasSubstr(c.message));
  }
  const auto lonely = Start({"drive", "--timeout", "1"}, "lonely.log");
  EXPECT_FALSE(lonely->WaitFor(std::chrono::milliseconds(300))) << "it waits for the robot";
}

}  // namespace
}  // namespace cairn::testing
