#include "deploy/launcher/record.h"

#include <fmt/core.h>
#include <sys/stat.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "common/bus/log_recorder.h"
#include "common/config/lcm_url.h"
#include "common/core/check.h"
#include "common/core/clock.h"
#include "deploy/launcher/meet_run.h"
#include "deploy/launcher/supervisor.h"

namespace cairn::deploy {
namespace {

constexpr auto kLook = std::chrono::milliseconds(200);  // for the run's end

std::vector<Plane> ParsePlanes(const std::string& text) {
  std::vector<Plane> planes;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const Plane plane = ParsePlane("--planes", text.substr(begin, end - begin));
    if (std::find(planes.begin(), planes.end(), plane) == planes.end()) planes.push_back(plane);
    begin = end + 1;
  }
  return planes;
}

// A recording is never written over.
void CheckOut(const std::string& out) {
  if (out.empty()) ThrowUsageError("log: --out FILE is missing");
  struct stat info {};
  if (stat(out.c_str(), &info) == 0 && !S_ISCHR(info.st_mode)) {
    ThrowUsageError("--out {}: it exists already; give another name", out);
  }
}

std::string Summary(const std::string& out, const std::vector<Plane>& planes, const RecordingStats& stats) {
  std::string line = fmt::format("{}: ", out);
  int64_t total = 0;
  for (const Plane plane : planes) {
    const int64_t messages = stats.messages[static_cast<size_t>(plane)];
    line += fmt::format("{} {}, ", messages, PlaneName(plane));
    total += messages;
  }
  line += fmt::format("{} messages, {:.1f} MB; ", total, 1e-6 * static_cast<double>(stats.bytes));
  if (stats.dropped() == 0) return line + "nothing dropped";
  return line + fmt::format("DROPPED {}: {} by the kernel's receive buffers, {} by the queue before the disk",
                            stats.dropped(), stats.dropped_by_kernel, stats.dropped_by_queue);
}

// What is to be recorded.
struct Subject {
  std::optional<RunInfo> run;
  BusConfig bus;
};

Subject FindSubject(const RecordOptions& options) {
  if (!options.run_dir.empty() && !options.lcm_url.empty()) {
    ThrowUsageError("--lcm-url {}: it does not go with a run directory, which knows its own", options.lcm_url);
  }
  if (!options.run_dir.empty()) {
    RunInfo info = MeetRun(options.run_dir);
    return {info, info.bus};
  }
  Subject subject;
  if (options.lcm_url.empty()) return subject;
  const TransportConfig transport = ParseLcmUrl(options.lcm_url);
  subject.bus.group = transport.group;
  subject.bus.base_port = transport.base_port;
  subject.bus.ttl = transport.ttl;
  subject.bus.broker = transport.broker;
  return subject;
}

}  // namespace

int Record(const RecordOptions& options) {
  const std::vector<Plane> planes = ParsePlanes(options.planes);
  CheckOut(options.out);
  const Subject subject = FindSubject(options);
  SignalEvents signals;
  LogRecorder recorder({subject.bus, planes, options.out});
  fmt::print("recording {} of {} to {}; Ctrl-C ends it\n", options.planes, PlaneUrl(subject.bus, planes.front()),
             options.out);
  std::fflush(stdout);
  const TimePoint start = Clock::now();
  bool away = false;
  while (signals.Wait(kLook) == 0) {
    const RecordingStats now = recorder.stats();
    if (!now.error.empty()) break;
    if (now.outage.has_value() != away && (away || Clock::now() - now.outage->since > kLook)) {
      away = !away;
      fmt::print(stderr, "{}\n", away ? "no broker (" + now.outage->reason + "): waiting" : "the broker is back");
    }
    if (options.duration_s > 0 && SecondsSince(start) > options.duration_s) break;
    if (subject.run && !IsLive(*subject.run)) break;
  }
  const RecordingStats stats = recorder.Finish();
  if (!stats.error.empty()) ThrowError("{}; until then: {}", stats.error, Summary(options.out, planes, stats));
  fmt::print("{}\n", Summary(options.out, planes, stats));
  return stats.dropped() == 0 ? 0 : 1;
}

}  // namespace cairn::deploy
