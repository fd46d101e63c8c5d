#include "common/config/process_options.h"

#include <fmt/core.h>

#include <charconv>

#include "common/config/command_line.h"
#include "common/config/lcm_url.h"
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

// What is read as text and then parsed.
struct Texts {
  std::string experiment;
  std::string run_id;
  std::optional<std::string> lcm_url;
};

void AddSharedOptions(CLI::App* app, ProcessOptions* options, Texts* texts) {
  app->add_option("file", options->experiment, "Resolved experiment file of the run");
  app->add_option("--experiment", texts->experiment)->group("");  // the same, as it was called before
  app->add_option("--run-id", texts->run_id, "Hexadecimal id of the run, the same for all its processes")->required();
  app->add_option("--run-dir", options->run_dir, "Run directory");
  app->add_option("--lcm-url", texts->lcm_url,
                  "udpm://GROUP:PORT?ttl=T, PORT the first of five, ttl 0 for this host only; or tcpq://HOST:PORT of "
                  "an LCM broker (default: the experiment's transport)");
  app->add_option("--key", options->key, "File with the key that the run's processes share");
  app->add_flag("--insecure", options->insecure, "Run without a key though other hosts can send (ttl of 1 or more)");
  app->add_option("--parent-fd", options->parent_fd, "Pipe whose end of file ends this process");
  app->add_option("--log-level", options->log_level, "Least level that is logged")
      ->check(CLI::IsMember({"debug", "info", "warning", "error"}));
}

void AddOwnOptions(ProcessKind kind, CLI::App* app, ProcessOptions* options) {
  if (kind == ProcessKind::kLearner) {
    app->add_option("--actors", options->actors, "Actors to expect")->check(CLI::Range(1, 65536));
    app->add_flag("--resume", options->resume, "Go on from the newest checkpoint in the run directory");
    app->add_option("--replay-log", options->replay_log,
                    "LCM log of the experience plane to train on; actors evaluate");
    app->add_option("--replay-key", options->replay_key, "File with the key that the log's messages are sealed with");
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
  Texts texts;
  CLI::App app(Description(kind), std::string("cairn-") + ProcessName(kind));
  app.set_version_flag("--version", std::string(GitRevision()));
  AddSharedOptions(&app, &options, &texts);
  AddOwnOptions(kind, &app, &options);
  if (!ParseCommandLine(&app, argc, argv)) return std::nullopt;
  if (options.experiment.empty() == texts.experiment.empty()) {
    ThrowUsageError("{0}: the experiment file is {1}; see {0} --help", app.get_name(),
                    options.experiment.empty() ? "missing" : "given twice, as FILE and --experiment");
  }
  if (options.experiment.empty()) options.experiment = texts.experiment;
  options.run_id = ParseRunId(texts.run_id);
  if (texts.lcm_url) options.transport = ParseLcmUrl(*texts.lcm_url);
  if (!options.key.empty() && options.insecure) ThrowUsageError("--insecure: it does not go with --key");
  return options;
}

std::vector<std::string> ToArguments(ProcessKind kind, const ProcessOptions& options) {
  std::vector<std::string> arguments{options.experiment, "--run-id", fmt::format("{:x}", options.run_id)};
  const auto add = [&](const char* name, const std::string& value) {
    arguments.emplace_back(name);
    arguments.push_back(value);
  };
  if (!options.run_dir.empty()) add("--run-dir", options.run_dir);
  if (options.transport) add("--lcm-url", ToLcmUrl(*options.transport));
  if (!options.key.empty()) add("--key", options.key);
  if (options.insecure) arguments.emplace_back("--insecure");
  if (options.parent_fd >= 0) add("--parent-fd", std::to_string(options.parent_fd));
  if (!options.log_level.empty()) add("--log-level", options.log_level);
  if (kind == ProcessKind::kLearner) {
    if (options.resume) arguments.emplace_back("--resume");
    add("--actors", std::to_string(options.actors));
    if (!options.replay_log.empty()) add("--replay-log", options.replay_log);
    if (!options.replay_key.empty()) add("--replay-key", options.replay_key);
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
  if (options.transport) {
    // The command line speaks of one broker; the file may name another one for telemetry.
    const std::string telemetry = options.transport->broker.empty() ? "" : transport.telemetry_broker;
    transport = *options.transport;
    transport.telemetry_broker = telemetry;
  }
  if (transport.leaves_host() && options.key.empty() && !options.insecure) {
    ThrowUsageError(
        "{}: other hosts can send to this run, so its messages need a key; give --key FILE (RUN_DIR/key of `cairn "
        "train`), or --insecure to do without",
        transport.broker.empty() ? fmt::format("ttl {}", transport.ttl) : ToLcmUrl(transport));
  }
  return loaded;
}

}  // namespace cairn
