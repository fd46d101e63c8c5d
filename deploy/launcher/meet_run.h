#pragma once

#include <string>

#include "common/bus/bus.h"
#include "deploy/launcher/run_directory.h"

namespace cairn::deploy {

/// Where the living run of a directory can be listened to, after entering its private network if it has one. An empty
/// `run_dir` gives the transport's defaults. Throws UsageError when there is no such run, Error when it has ended.
RunInfo MeetRun(const std::string& run_dir);

/// A plane by its name. Throws UsageError naming `option`, the name and the nearest known one.
Plane ParsePlane(const std::string& option, const std::string& name);

}  // namespace cairn::deploy
