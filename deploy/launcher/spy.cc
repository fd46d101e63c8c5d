#include "deploy/launcher/spy.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "common/bus/bus.h"
#include "common/config/nearest_name.h"
#include "common/core/check.h"
#include "deploy/launcher/network.h"
#include "deploy/launcher/run_directory.h"
#include "deploy/launcher/sibling.h"

namespace cairn::deploy {
namespace {

namespace fs = std::filesystem;

Plane ParsePlane(const std::string& name) {
  std::vector<std::string> names;
  for (int i = 0; i < kNumPlanes; ++i) {
    const auto plane = static_cast<Plane>(i);
    if (name == PlaneName(plane)) return plane;
    names.push_back(PlaneName(plane));
  }
  ThrowUsageError("--plane {}: it must be telemetry, experience, control or tables; the nearest is {}", name,
                  NearestName(name, names));
}

// The packaged lcm-spy script passes an option that JDK 17 refuses and forgets the chart library.
std::string ClassPath() {
  std::string path;
  const auto add = [&](const std::string& jar, const char* package) {
    if (!fs::exists(jar)) ThrowError("cannot find {}; {}", jar, package);
    path += (path.empty() ? "" : ":") + jar;
  };
  add("/usr/share/java/lcm.jar", "install liblcm-java");
  add("/usr/share/java/jchart2d.jar", "install libjchart2d-java");
  const std::string ours = fs::path(ProgramDirectory() + "/../share/cairn/cairn_lcmtypes.jar").lexically_normal();
  add(ours, "without it lcm-spy cannot decode Cairn's messages; build the target cairn_lcmtypes_jar");
  return path;
}

std::string FindJava() {
  const char* path = std::getenv("PATH");
  const std::string list = path == nullptr ? "" : path;
  for (size_t begin = 0; begin <= list.size();) {
    const size_t end = std::min(list.find(':', begin), list.size());
    const std::string candidate = list.substr(begin, end - begin) + "/java";
    if (access(candidate.c_str(), X_OK) == 0) return candidate;
    begin = end + 1;
  }
  ThrowError("cannot find java in PATH; install default-jre");
}

void CheckDisplay() {
  const char* display = std::getenv("DISPLAY");
  if (display != nullptr && *display != '\0') return;
  ThrowError("DISPLAY is not set: lcm-spy needs a window system; on a host without one use xvfb-run cairn spy");
}

BusConfig FindBus(const SpyOptions& options) {
  if (options.run_dir.empty()) return {};
  const RunInfo info = ReadRunInfo(RunDirectory::Open(options.run_dir));
  const auto pid = static_cast<pid_t>(info.pid);
  if (!IsLive(info)) {
    ThrowError("{}: the run has ended (its launcher, process {}, is gone)", options.run_dir, info.pid);
  }
  if (info.network.is_private) JoinNetworkOf(pid);
  return info.bus;
}

}  // namespace

int Spy(const SpyOptions& options) {
  const Plane plane = ParsePlane(options.plane);
  CheckDisplay();
  const std::string java = FindJava();
  const std::string class_path = ClassPath();
  const std::string url = PlaneUrl(FindBus(options), plane);
  setenv("LCM_DEFAULT_URL", url.c_str(), 1);
  // The spy finds our types and plug-ins by scanning CLASSPATH.
  setenv("CLASSPATH", class_path.c_str(), 1);
  execl(java.c_str(), java.c_str(), "-Djava.net.preferIPv4Stack=true", "-cp", class_path.c_str(), "lcm.spy.Spy",
        nullptr);
  ThrowError("cannot start {}: {}", java, std::strerror(errno));
}

}  // namespace cairn::deploy
