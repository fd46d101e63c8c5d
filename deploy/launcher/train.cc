#include "deploy/launcher/train.h"

#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <memory>

#include "common/bus/broker_connection.h"
#include "common/bus/key_file.h"
#include "common/bus/log_file.h"
#include "common/config/load.h"
#include "common/config/process_options.h"
#include "common/core/check.h"
#include "common/core/clock.h"
#include "common/core/hash.h"
#include "common/core/log.h"
#include "common/world/distance_field.h"
#include "common/world/world_variants.h"
#include "deploy/launcher/cpus.h"
#include "deploy/launcher/network.h"
#include "deploy/launcher/port_block.h"
#include "deploy/launcher/run_directory.h"
#include "deploy/launcher/sibling.h"
#include "deploy/launcher/supervisor.h"
#include "planner/planner.h"

namespace cairn::deploy {
namespace {

// The learner takes up to 10 s to reach a checkpoint, and a slow disk its time to write it; a second signal does not
// wait.
constexpr auto kLearnerStopTime = std::chrono::seconds(60);

void CheckActors(const TrainOptions& options, const Experiment& experiment) {
  if (options.actors <= experiment.num_vehicles) return;
  ThrowUsageError("--actors {}: num_vehicles = {}, and each actor needs at least one", options.actors,
                  experiment.num_vehicles);
}

bool AnyPlace(const PlaceArguments& place) {
  return !(place.map.empty() && place.robot.empty() && place.goal.empty() && place.start.empty());
}

// Either a file or a run to go on with, which has its own.
void CheckSource(const TrainOptions& options) {
  if (options.resume.empty()) {
    if (options.file.empty()) ThrowUsageError("train: an experiment file is missing (or --resume RUN_DIR)");
    return;
  }
  const char* other = !options.file.empty()         ? "an experiment file"
                      : !options.run_dir.empty()    ? "--run-dir"
                      : !options.overrides.empty()  ? "--set or --seed"
                      : !options.replay_log.empty() ? "--replay-log"
                      : AnyPlace(options.place)     ? "--map, --robot, --goal or --start"
                                                    : nullptr;
  if (other != nullptr) {
    ThrowUsageError("--resume {}: {} does not go with it; the run has its own experiment.textproto", options.resume,
                    other);
  }
}

std::string ProgramOf(ProcessKind kind) { return SiblingProgram(std::string("cairn-") + ProcessName(kind)); }

// What the planner would refuse, found before anything is written or started. Costs a few milliseconds.
void CheckWorld(const Experiment& experiment) {
  const World world = MakeWorldVariants(experiment).known;
  const DistanceField field(world, experiment.world.field_resolution);
  planner::CheckPlannable(world, field, experiment.planner, experiment.vehicle.inscribed_radius());
}

// What the learner would find later.
void CheckLog(const TrainOptions& options) {
  if (!options.replay_key.empty()) {
    if (options.replay_log.empty()) ThrowUsageError("--replay-key: it goes with --replay-log only");
    ReadKeyFile(options.replay_key);
  }
  if (!options.replay_log.empty()) const LogReader readable(options.replay_log);
}

// Found before anything is written: a run without its broker would only wait.
void CheckBroker(const std::string& option, const std::string& broker) {
  if (broker.empty()) return;
  const std::string fault = ProbeBroker(broker);
  if (fault.empty()) return;
  ThrowError("{} = \"tcpq://{}\": no broker: {}; start one: {}", option, broker, fault, BrokerCommand(broker));
}

// Over a broker there is no multicast to need a route or a network of its own, nor ports to share.
NetworkInfo PrepareTransport(const TransportConfig& transport) {
  if (transport.broker.empty()) return PrepareNetwork(transport.group, transport.ttl);
  CheckBroker("transport.url", transport.broker);
  CheckBroker("transport.telemetry_url", transport.telemetry_broker);
  return {false, false, NetworkInode(getpid())};
}

std::optional<PortBlock> ClaimPorts(const TransportConfig& transport) {
  if (transport.broker.empty()) return PortBlock::Claim(transport.base_port);
  return std::nullopt;
}

// Holds what the run needs as long as it lasts, and starts its processes.
class Training {
 public:
  Training(const TrainOptions& options, LoadedExperiment loaded)
      : options_(options),
        loaded_(std::move(loaded)),
        num_actors_(options.actors > 0 ? options.actors : DefaultActors(loaded_.experiment.num_vehicles)),
        network_(PrepareTransport(loaded_.experiment.transport)),
        ports_(ClaimPorts(loaded_.experiment.transport)),
        directory_(options.resume.empty()
                       ? RunDirectory::Create(options.run_dir, loaded_.experiment.name, loaded_.resolved_text,
                                              loaded_.experiment.world.map.file, loaded_.experiment.planner.roadmap)
                       : RunDirectory::Resume(options.resume, loaded_.experiment.total_env_steps)),
        status_line_(stdout, StatusLine::ModeFor(stdout, options.quiet)) {
    log::Init("cairn", directory_.log_file("launcher"));
    const TransportConfig& transport = loaded_.experiment.transport;
    bus_ = {transport.group,  ports_ ? ports_->base_port() : transport.base_port,
            transport.ttl,    RandomId(),
            RandomId(),       MakeKey(),
            transport.broker, transport.telemetry_broker};
    WriteRunInfo(directory_, {getpid(), bus_.run_id, bus_, network_, num_actors_});
  }

  int Run(const MakeStatusSource& make_status_source) {
    Announce();
    if (make_status_source) source_ = make_status_source(bus_);
    Supervisor supervisor(&signals_, MakeSupervisorConfig());
    AddProcesses(&supervisor);
    const RunEnd end = supervisor.Run();
    UpdateStatus();
    status_line_.Finish();
    return Report(end);
  }

 private:
  // The run's own, or a new one; none where no other host hears or sends. LCM's broker takes connections from all hosts
  // whatever address the run calls it by.
  std::optional<RunKey> MakeKey() const {
    const TransportConfig& transport = loaded_.experiment.transport;
    const bool reached = transport.leaves_host() || !transport.broker.empty();
    if (!reached || options_.insecure) return std::nullopt;
    const std::string file = directory_.key_file();
    return std::filesystem::exists(file) ? ReadKeyFile(file) : CreateKeyFile(file);
  }

  void Say(const std::string& line) {
    log::Info("{}", line);
    status_line_.Note(line);
  }

  void Announce() {
    const LearnerConfig& learner = loaded_.experiment.learner;
    Say(fmt::format("{}: {} actors, {} vehicles, run directory {}", loaded_.experiment.name, num_actors_,
                    loaded_.experiment.num_vehicles, directory_.path()));
    if (!options_.resume.empty()) Say("going on from the newest checkpoint");
    if (ports_ && !ports_->note().empty()) Say(ports_->note());
    const bool leaves_host = loaded_.experiment.transport.leaves_host();
    if (leaves_host) {
      std::string copied = "experiment.textproto";
      if (loaded_.experiment.world.imported != nullptr) copied += ", map";
      if (!loaded_.experiment.planner.roadmap.empty()) copied += ", roadmap";
      if (bus_.key) copied += " and key";
      Say(fmt::format("other hosts join with copies of the run directory's {}: {}", copied, JoinCommand(bus_)));
    }
    if (!bus_.broker.empty()) Say(fmt::format("all messages go through the broker tcpq://{}", bus_.broker));
    if ((leaves_host || !bus_.broker.empty()) && !bus_.key) {
      Say(fmt::format("no key: whoever can send to {} can take part in the run",
                      bus_.broker.empty() ? "these ports" : "the broker"));
    }
    if (network_.is_private) {
      Say(fmt::format("no multicast route: running in a private network; look inside with: {}",
                      LookInsideCommand(getpid(), network_)));
    }
    if (learner.learning_starts >= loaded_.experiment.total_env_steps) {
      Say(fmt::format("learner.learning_starts = {} is not below total_env_steps = {}: nothing will be learnt",
                      learner.learning_starts, loaded_.experiment.total_env_steps));
    }
  }

  SupervisorConfig MakeSupervisorConfig() {
    SupervisorConfig config;
    config.tick = [this] { UpdateStatus(); };
    config.note = [this](const std::string& line) { Say(line); };
    config.max_restarts = options_.max_restarts;
    config.main_kill_after = kLearnerStopTime;
    return config;
  }

  void UpdateStatus() {
    if (!source_) return;
    if (const std::optional<RunStatus> status = source_()) status_line_.Update(*status);
  }

  ProcessOptions Options(const Supervisor& supervisor) const {
    ProcessOptions options;
    options.experiment = directory_.experiment_file();
    options.run_dir = directory_.path();
    options.run_id = bus_.run_id;
    options.transport = TransportConfig{bus_.group, bus_.base_port, bus_.ttl, bus_.broker, ""};
    if (bus_.key) options.key = directory_.key_file();
    options.insecure = loaded_.experiment.transport.leaves_host() && !bus_.key;
    options.parent_fd = supervisor.parent_fd();
    options.resume = !options_.resume.empty();
    options.actors = num_actors_;
    options.replay_log = options_.replay_log;
    options.replay_key = options_.replay_key;
    options.launch_utime_us = options_.launch_utime_us;
    return options;
  }

  Command MakeCommand(ProcessKind kind, const std::string& name, const ProcessOptions& options) const {
    return {name, ProgramOf(kind), ToArguments(kind, options), directory_.log_file(name)};
  }

  void AddProcesses(Supervisor* supervisor) {
    const ProcessOptions options = Options(*supervisor);
    const auto add = [&](ProcessKind kind, Role role, const ProcessOptions& own) {
      std::string name = ProcessName(kind);
      if (kind == ProcessKind::kActor) name += fmt::format("-{}", own.actor_id);
      const auto command = [this, kind, name, own](int generation) {
        ProcessOptions next = own;
        next.generation = generation;
        if (kind == ProcessKind::kLearner && generation > 0) {
          next.resume = true;
          next.launch_utime_us = MonotonicUs();
        }
        return MakeCommand(kind, name, next);
      };
      supervisor->Add({name, role, command});
    };
    add(ProcessKind::kPlanner, Role::kService, options);
    add(ProcessKind::kLearner, Role::kMain, options);
    for (int id = 0; id < num_actors_; ++id) {
      ProcessOptions own = options;
      own.actor_id = id;
      add(ProcessKind::kActor, Role::kWorker, own);
    }
  }

  int Report(const RunEnd& end) {
    if (end.exit_code > 128) {
      Say(directory_.has_checkpoint()
              ? fmt::format("stopped; go on with: cairn train --resume {}", directory_.path())
              : std::string("stopped before the first checkpoint: there is nothing to go on from"));
      return end.exit_code;
    }
    if (end.exit_code == 2) throw UsageError(end.failure);
    if (end.exit_code != 0) throw Error(end.failure);
    std::string restarts;
    if (end.restarts > 0) restarts = fmt::format(", {} restart{}", end.restarts, end.restarts > 1 ? "s" : "");
    Say(fmt::format("done in {:.1f} s{}; run directory {}",
                    1e-6 * static_cast<double>(MonotonicUs() - options_.launch_utime_us), restarts, directory_.path()));
    return 0;
  }

  const TrainOptions& options_;
  LoadedExperiment loaded_;
  int num_actors_;
  NetworkInfo network_;  // entered while single-threaded: before anything below
  SignalEvents signals_;
  std::optional<PortBlock> ports_;  // none over a broker
  RunDirectory directory_;
  StatusLine status_line_;
  BusConfig bus_;
  StatusSource source_;
};

}  // namespace

int Train(const TrainOptions& options, const MakeStatusSource& make_status_source) {
  CheckSource(options);
  CheckLog(options);
  LoadedExperiment loaded = options.resume.empty()
                                ? LoadExperiment(options.file, options.overrides, options.place)
                                : LoadExperiment(RunDirectory::Open(options.resume).experiment_file());
  CheckActors(options, loaded.experiment);
  CheckWorld(loaded.experiment);
  if (!options.run_dir.empty()) RunDirectory::CheckVacant(options.run_dir);
  for (const auto kind : {ProcessKind::kPlanner, ProcessKind::kLearner, ProcessKind::kActor}) ProgramOf(kind);
  std::signal(SIGPIPE, SIG_IGN);  // a reader of our lines that goes away does not end the run
  Training training(options, std::move(loaded));
  return training.Run(make_status_source);
}

}  // namespace cairn::deploy
