#pragma once

#include <string>
#include <vector>

#include "actors/environment.h"
#include "common/bus/messages.h"
#include "common/config/load.h"

namespace cairn::deploy {

/// What was typed after `cairn robot`.
struct StandInOptions {
  std::string run_dir;
  std::string lcm_url;  ///< as of DriveOptions
  std::string name = "ROBOT";
  int trial = 0;     ///< test start where it stands at first
  double speed = 1;  ///< simulated seconds a second; 0: as fast as commands come
  std::vector<std::string> overrides;
  PlaceArguments place;  ///< --map, --goal
};

/// Stands in for a robot: the run's vehicle under simulated physics, with the experiment's disturbances, noise, delay
/// and safety filter, sends what it measures and does what `cairn drive` says. Returns 0 when it has reached the goal,
/// 1 when it has touched something or run out of time, 128 + n when stopped by signal n; throws UsageError or Error.
int StandIn(const StandInOptions& options);

/// A scan that serves the policy's beams and, where the experiment has a safety filter for the plane, that one's rays.
ScanConfig DenseScan(const Experiment& experiment);

/// What the vehicle of an environment measures now, by such a scan.
RobotState Measure(const actors::Environment& environment, const ScanConfig& scan, int64_t utime);

}  // namespace cairn::deploy
