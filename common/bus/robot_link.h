#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "common/bus/messages.h"
#include "common/core/clock.h"

namespace cairn {

/// Where a robot and who drives it talk: NAME_STATE and NAME_COMMAND on one port, LCM's own default unless told.
struct RobotAddress {
  std::string group = "239.255.76.67";
  int port = 7667;
  int ttl = 0;
  std::string name = "ROBOT";

  std::string url() const;
};

/// The messages between a robot and who drives it: plain LCM, without frames and keys, so that a robot's driver needs
/// nothing but LCM and two types. One thread.
class RobotLink {
 public:
  enum class End { kDriver, kRobot };  ///< who hears states and sends commands, or the other way round

  /// Throws UsageError when the name is not 1 to 12 letters, digits and underscores, Error with the cure when the group
  /// cannot be joined.
  RobotLink(const RobotAddress& address, End end);
  ~RobotLink();
  RobotLink(const RobotLink&) = delete;
  RobotLink& operator=(const RobotLink&) = delete;

  void Send(const RobotState& state);
  void Send(const RobotCommand& command);

  /// The newest one that has come since the last call, waiting up to `timeout` for one. Of the own end only.
  std::optional<RobotState> WaitForState(Duration timeout);
  std::optional<RobotCommand> WaitForCommand(Duration timeout);

  /// Datagrams on the channel that are no such message.
  int64_t refused() const;
  /// The channel that is heard.
  const std::string& channel() const;

 private:
  struct Lcm;
  std::unique_ptr<Lcm> lcm_;
};

}  // namespace cairn
