#include "deploy/doctor/subject.h"

#include <algorithm>
#include <filesystem>

#include "common/config/lcm_url.h"
#include "common/config/load.h"
#include "common/core/check.h"
#include "deploy/launcher/network.h"
#include "deploy/launcher/run_directory.h"

namespace cairn::deploy {
namespace {

namespace fs = std::filesystem;

// What is always written: networks, logs, curves, episodes.
constexpr int64_t kFixedBytes = 32 << 20;
constexpr int64_t kBytesPerTransition = 256;  // of replay, in checkpoints (docs/operations.md)

int64_t DiskBytes(const Experiment& experiment) {
  const int64_t rows = std::min<int64_t>(experiment.total_env_steps, experiment.learner.buffer_size);
  return kFixedBytes + kBytesPerTransition * rows;
}

// The directory itself or the nearest one above it that exists.
std::string Existing(const std::string& directory) {
  fs::path path = directory.empty() ? fs::current_path() : fs::absolute(directory).lexically_normal();
  std::error_code unreadable;  // its own line says so
  while (!fs::is_directory(path, unreadable)) path = path.parent_path();
  return path.string();
}

void ReadRun(const RunDirectory& run, Subject* subject) {
  const LoadedExperiment loaded = LoadExperiment(run.experiment_file());
  subject->transport = loaded.experiment.transport;
  subject->disk_bytes = DiskBytes(loaded.experiment);
  subject->disk = run.path();
  subject->key_file = run.key_file();
  subject->key_required = true;
  if (!fs::exists(run.info_file())) return;  // started by hand
  const RunInfo info = ReadRunInfo(run);
  subject->transport =
      TransportConfig{info.bus.group, info.bus.base_port, info.bus.ttl, info.bus.broker, info.bus.telemetry_broker};
  subject->run_host = info.host;
  if (!IsLive(info)) return;
  subject->live_pid = info.pid;
  if (info.network.is_private) JoinNetworkOf(static_cast<pid_t>(info.pid));
}

void ReadFileAt(const DoctorOptions& options, Subject* subject) {
  const LoadedExperiment loaded = LoadExperiment(options.subject, options.overrides, options.place);
  subject->transport = loaded.experiment.transport;
  subject->disk_bytes = DiskBytes(loaded.experiment);
  subject->disk = Existing(options.run_dir);
  subject->key_file = (fs::absolute(options.subject).parent_path() / "key").string();
}

void CheckUsage(const DoctorOptions& options, bool is_run) {
  const bool is_file = !options.subject.empty() && !is_run;
  if (!is_file && !options.overrides.empty()) ThrowUsageError("--set: it goes with an experiment file");
  const PlaceArguments& place = options.place;
  const bool placed = !(place.map.empty() && place.robot.empty() && place.goal.empty() && place.start.empty());
  if (!is_file && placed) ThrowUsageError("--map, --robot, --goal, --start: they go with an experiment file");
  if (is_run && !options.run_dir.empty()) ThrowUsageError("--run-dir: it does not go with a run directory");
  if (!options.key.empty() && options.insecure) ThrowUsageError("--insecure: it does not go with --key");
}

}  // namespace

Subject FindSubject(const DoctorOptions& options) {
  std::error_code none;
  const bool is_run = fs::is_directory(options.subject, none);
  CheckUsage(options, is_run);
  Subject subject;
  if (is_run) {
    ReadRun(RunDirectory::Open(options.subject), &subject);
  } else if (!options.subject.empty()) {
    ReadFileAt(options, &subject);
  } else {
    subject.from_defaults = options.lcm_url.empty();
    subject.disk = Existing(options.run_dir);
    subject.disk_bytes = DiskBytes(Experiment{});
    subject.key_file = "key";
  }
  if (!options.lcm_url.empty()) subject.transport = ParseLcmUrl(options.lcm_url);
  if (!options.key.empty()) {
    subject.key_file = options.key;
    subject.key_required = true;
  }
  subject.insecure = options.insecure;
  return subject;
}

}  // namespace cairn::deploy
