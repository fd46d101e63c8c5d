#include "deploy/launcher/meet_run.h"

#include "common/config/nearest_name.h"
#include "common/core/check.h"
#include "deploy/launcher/network.h"

namespace cairn::deploy {
RunInfo MeetRun(const std::string& run_dir) {
  if (run_dir.empty()) return {};
  RunInfo info = ReadRunInfo(RunDirectory::Open(run_dir));
  if (!info.host.empty() && info.host != HostName()) {
    ThrowError("{}: the run was started on {}, and this is {}; look at it there", run_dir, info.host, HostName());
  }
  if (!IsLive(info)) ThrowError("{}: the run has ended (its launcher, process {}, is gone)", run_dir, info.pid);
  if (info.network.is_private) JoinNetworkOf(static_cast<pid_t>(info.pid));
  return info;
}

Plane ParsePlane(const std::string& option, const std::string& name) {
  std::vector<std::string> names;
  for (int i = 0; i < kNumPlanes; ++i) {
    const auto plane = static_cast<Plane>(i);
    if (name == PlaneName(plane)) return plane;
    names.push_back(PlaneName(plane));
  }
  ThrowUsageError("{} {}: it must be telemetry, experience, control or tables; the nearest is {}", option, name,
                  NearestName(name, names));
}

}  // namespace cairn::deploy
