#include "common/config/process_options.h"

#include <fmt/core.h>

#include <charconv>

#include "common/config/command_line.h"
#include "common/core/check.h"
#include "common/core/version.h"

namespace cairn {
namespace {

const char* Description(ProcessKind kind) {
  switch (kind) {
    case ProcessKind::kPlanner:
      return "Builds the roadmap of an experiment's world and serves cost tables to learner and actors.";
    case ProcessKind::kLearner:
      return "Turns the actors' experience into policies. One per run.";
    case ProcessKind::kActor:
      return "Rolls out vehicles with the learner's newest policy. As many per run as there are CPUs.";
  }
  return "";
}

int64_t ParseRunId(const std::string& text) {
  uint64_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id, 16);
  if (error != std::errc() || end != text.data() + text.size() || id == 0 || id > INT64_MAX) {
    ThrowUsageError("--run-id {}: it must be a hexadecimal number from 1 to 7fffffffffffffff", text);
  }
  return static_cast<int64_t>(id);
}

void AddSharedOptions(CLI::App* app, ProcessOptions* options, std::string* run_id) {
  app->add_option("--experiment", options->experiment, "Resolved experiment file of the run")->required();
  app->add_option("--run-id", *run_id, "Hexadecimal id of the run, the same for all its processes")->required();
  app->add_option("--run-dir", options->run_dir, "Run directory");
  app->add_option("--url-group", options->group, "Multicast group (default: the experiment's)");
  app->add_option("--base-port", options->base_port, "First of five UDP ports (default: the experiment's)")
      ->check(CLI::Range(1024, 65530));
  app->add_option("--ttl", options->ttl, "0: this host only (default: the experiment's)")->check(CLI::Range(0, 255));
  app->add_option("--parent-fd", options->parent_fd, "Pipe whose end of file ends this process");
  app->add_option("--log-level", options->log_level, "Least level that is logged")
      ->check(CLI::IsMember({"debug", "info", "warning", "error"}));
}

void AddOwnOptions(ProcessKind kind, CLI::App* app, ProcessOptions* options) {
  if (kind == ProcessKind::kLearner) {
    app->add_option("--actors", options->actors, "Actors to expect")->check(CLI::Range(1, 65536));
    app->add_flag("--resume", options->resume, "Go on from the newest checkpoint in the run directory");
    app->add_option("--launch-utime-us", options->launch_utime_us, "Monotonic time of the launch, microseconds");
  } else if (kind == ProcessKind::kActor) {
    app->add_option("--actor-id", options->actor_id, "Index of this actor")->check(CLI::Range(0, 65535));
    app->add_option("--generation", options->generation, "Number of processes that had this id before")
        ->check(CLI::NonNegativeNumber);
  }
}

}  // namespace

const char* ProcessName(ProcessKind kind) {
  switch (kind) {
    case ProcessKind::kPlanner:
      return "planner";
    case ProcessKind::kLearner:
      return "learner";
    case ProcessKind::kActor:
      return "actor";
  }
  return "";
}

std::optional<ProcessOptions> ParseProcessOptions(ProcessKind kind, int argc, const char* const* argv) {
  ProcessOptions options;
  std::string run_id;
  CLI::App app(Description(kind), std::string("cairn-") + ProcessName(kind));
  app.set_version_flag("--version", std::string(GitRevision()));
  AddSharedOptions(&app, &options, &run_id);
  AddOwnOptions(kind, &app, &options);
  if (!ParseCommandLine(&app, argc, argv)) return std::nullopt;
  options.run_id = ParseRunId(run_id);
  return options;
}

std::vector<std::string> ToArguments(ProcessKind kind, const ProcessOptions& options) {
  std::vector<std::string> arguments{"--experiment", options.experiment, "--run-id",
                                     fmt::format("{:x}", options.run_id)};
  const auto add = [&](const char* name, const std::string& value) {
    arguments.push_back(name);
    arguments.push_back(value);
  };
  if (!options.run_dir.empty()) add("--run-dir", options.run_dir);
  if (!options.group.empty()) add("--url-group", options.group);
  if (options.base_port > 0) add("--base-port", std::to_string(options.base_port));
  if (options.ttl >= 0) add("--ttl", std::to_string(options.ttl));
  if (options.parent_fd >= 0) add("--parent-fd", std::to_string(options.parent_fd));
  if (!options.log_level.empty()) add("--log-level", options.log_level);
  if (kind == ProcessKind::kLearner) {
    if (options.resume) arguments.push_back("--resume");
    add("--actors", std::to_string(options.actors));
    add("--launch-utime-us", std::to_string(options.launch_utime_us));
  }
  if (kind == ProcessKind::kActor) {
    add("--actor-id", std::to_string(options.actor_id));
    add("--generation", std::to_string(options.generation));
  }
  return arguments;
}

LoadedExperiment LoadProcessExperiment(const ProcessOptions& options) {
  LoadedExperiment loaded = LoadExperiment(options.experiment);
  TransportConfig& transport = loaded.experiment.transport;
  if (!options.group.empty()) transport.group = options.group;
  if (options.base_port > 0) transport.base_port = options.base_port;
  if (options.ttl >= 0) transport.ttl = options.ttl;
  return loaded;
}

}  // namespace cairn
