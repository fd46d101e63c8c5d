#pragma once

#include <string>
#include <vector>

#include "common/bus/robot_link.h"
#include "common/config/load.h"

namespace cairn::deploy {

/// What was typed after `cairn drive`.
struct DriveOptions {
  std::string run_dir;
  std::string policy;                  ///< best or last; empty: the best if there is one, else the last
  std::string lcm_url;                 ///< udpm://GROUP:PORT?ttl=T; empty: RobotAddress's
  std::string name = "ROBOT";          ///< channels NAME_STATE and NAME_COMMAND
  double timeout = 0;                  ///< [s] to arrive within from the first state on; 0: none
  std::vector<std::string> overrides;  ///< of the run's experiment, as typed after --set
  PlaceArguments place;                ///< --map, --goal
};

/// Drives the robot behind the messages with a run's policy to the goal. Returns 0 when it has arrived, 1 when not
/// within the timeout, 128 + n when stopped by signal n, after telling the robot to stand still; throws UsageError or
/// Error.
int Drive(const DriveOptions& options);

/// Reads --lcm-url and --name. Throws UsageError naming the option and the rule.
RobotAddress ParseRobotAddress(const std::string& lcm_url, const std::string& name);

}  // namespace cairn::deploy
