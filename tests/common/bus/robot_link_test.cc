#include "common/bus/robot_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <lcm/lcm-cpp.hpp>

#include "common/core/check.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(RobotLinkTest, CarriesStatesOneWayAndCommandsTheOther) {
  const RobotAddress address{.port = 23710};
  RobotLink driver(address, RobotLink::End::kDriver), robot(address, RobotLink::End::kRobot);
  EXPECT_EQ(driver.channel(), "ROBOT_STATE");
  EXPECT_FALSE(driver.WaitForState(milliseconds(1)));
  robot.Send(RobotState{.utime = 5, .pose = {1, 2, 3, 4}, .angle_step = 1, .ranges = {1, 2}});
  const std::optional<RobotState> state = driver.WaitForState(seconds(10));
  ASSERT_TRUE(state);
  EXPECT_EQ(state->utime, 5);
  EXPECT_EQ(state->ranges, (std::vector<float>{1, 2}));
  driver.Send(RobotCommand{.state_utime = 5, .mode = RobotCommand::Mode::kDrive, .command = {0.5, -1}, .note = "n"});
  const std::optional<RobotCommand> command = robot.WaitForCommand(seconds(10));
  ASSERT_TRUE(command);
  EXPECT_EQ(command->state_utime, 5);
  EXPECT_EQ(command->command, (std::vector<double>{0.5, -1}));
  EXPECT_FALSE(driver.WaitForState(milliseconds(1))) << "each is given once";
}

TEST(RobotLinkTest, TheNewestCountsAndGarbageIsRefused) {
  const RobotAddress address{.port = 23711, .name = "Car_7"};
  RobotLink driver(address, RobotLink::End::kDriver), robot(address, RobotLink::End::kRobot);
  lcm::LCM plain(address.url());
  plain.publish("Car_7_STATE", "garbage", 7);
  for (int i = 1; i <= 5; ++i) robot.Send(RobotState{.utime = i});
  // Loopback keeps the order, so that the mark is the last of them.
  std::optional<RobotState> state;
  for (int i = 0; i < 1000 && (!state || state->utime < 5); ++i) {
    if (auto next = driver.WaitForState(milliseconds(10))) state = std::move(next);
  }
  ASSERT_TRUE(state);
  EXPECT_EQ(state->utime, 5);
  EXPECT_EQ(driver.refused(), 1);
}

TEST(RobotLinkTest, NamesAreChecked) {
  for (const char* name : {"", "a b", "much_too_long", "a/b"}) {
    EXPECT_THROW(RobotLink({.port = 23712, .name = name}, RobotLink::End::kRobot), UsageError) << name;
  }
}

}  // namespace
}  // namespace cairn
