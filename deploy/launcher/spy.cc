#include "deploy/launcher/spy.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "common/bus/bus.h"
#include "common/core/check.h"
#include "deploy/launcher/meet_run.h"
#include "deploy/launcher/sibling.h"

namespace cairn::deploy {
namespace {

namespace fs = std::filesystem;

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

}  // namespace

int Spy(const SpyOptions& options) {
  const Plane plane = ParsePlane("--plane", options.plane);
  CheckDisplay();
  const std::string java = FindJava();
  const std::string class_path = ClassPath();
  const std::string url = PlaneUrl(MeetRun(options.run_dir).bus, plane);
  setenv("LCM_DEFAULT_URL", url.c_str(), 1);
  // The spy finds our types and plug-ins by scanning CLASSPATH.
  setenv("CLASSPATH", class_path.c_str(), 1);
  execl(java.c_str(), java.c_str(), "-Djava.net.preferIPv4Stack=true", "-cp", class_path.c_str(), "lcm.spy.Spy",
        nullptr);
  ThrowError("cannot start {}: {}", java, std::strerror(errno));
}

}  // namespace cairn::deploy
