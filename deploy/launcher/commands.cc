#include "deploy/launcher/commands.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "common/config/command_line.h"
#include "common/core/check.h"
#include "common/core/version.h"
#include "deploy/doctor/doctor.h"
#include "deploy/launcher/eval.h"
#include "deploy/launcher/plan.h"
#include "deploy/launcher/record.h"
#include "deploy/launcher/sibling.h"
#include "deploy/launcher/spy.h"
#include "deploy/launcher/telemetry_status.h"
#include "deploy/launcher/train.h"
#include "deploy/robot/drive.h"
#include "deploy/robot/stand_in.h"

namespace cairn::deploy {
namespace {

constexpr const char* kSetHelp =
    "Override an option of the file: --set learner.batch_size=512, lists as learner.net_arch=[64,64]; repeatable, "
    "the last one wins";

// One command: its options are bound when it is declared, `run` is called after parsing.
struct Commands {
  std::function<int()> run;
};

void AddOverrides(CLI::App* command, std::vector<std::string>* overrides) {
  command->add_option("--set", *overrides, kSetHelp)->type_name("KEY=VALUE")->allow_extra_args(false);
}

void AddPlace(CLI::App* command, PlaceArguments* place) {
  command->add_option("--map", place->map,
                      "Map in the place of the file's world: .yaml (map_server), .bt (OctoMap), .map (Moving AI), "
                      ".world (BARN)");
  command->add_option("--robot", place->robot, "File with a Vehicle in the place of the experiment's");
  command->add_option("--goal", place->goal, "Centre of the goal region, metres in the map's frame")->type_name("X,Y");
  command->add_option("--start", place->start, "Centre of the start region (default: everywhere free)")
      ->type_name("X,Y");
}

void AddTrain(CLI::App* app, Commands* commands, int64_t launch_utime_us) {
  auto options = std::make_shared<TrainOptions>();
  auto seed = std::make_shared<std::string>();
  options->launch_utime_us = launch_utime_us;
  CLI::App* command = app->add_subcommand("train", "Train a policy: starts planner, learner and actors");
  command->add_option("file", options->file, "Experiment file");
  command->add_option("--resume", options->resume,
                      "Run directory of an interrupted run to go on with, instead of a file");
  command->add_option("--run-dir", options->run_dir, "Run directory (default: runs/<name>-<date>-<time>)");
  command->add_option("--actors", options->actors, "Actor processes (default: the CPUs less one, two on two CPUs)")
      ->check(CLI::Range(1, 65536));
  command->add_option("--seed", *seed, "Seed of everything but the world");
  AddPlace(command, &options->place);
  AddOverrides(command, &options->overrides);
  command->add_option("--replay-log", options->replay_log,
                      "LCM log of an experience plane (cairn log) to train on; the actors only evaluate");
  command->add_option("--replay-key", options->replay_key,
                      "Key file of the run that the log was recorded from, if it had one");
  command->add_flag("--insecure", options->insecure, "Without a key though other hosts can send (ttl of 1 or more)");
  command
      ->add_option("--max-restarts", options->max_restarts,
                   "Processes that die are started again, all together at most this often within a minute")
      ->check(CLI::Range(0, 1000000000))
      ->capture_default_str();
  command->add_flag("--quiet", options->quiet, "No status line");
  command->callback([options, seed, commands] {
    if (!seed->empty()) options->overrides.push_back("seed=" + *seed);
    commands->run = [options] { return Train(*options, MakeTelemetryStatus); };
  });
}

void AddPlan(CLI::App* app, Commands* commands) {
  auto options = std::make_shared<PlanOptions>();
  CLI::App* command = app->add_subcommand("plan", "Build the roadmap of an experiment's world and draw it");
  command->add_option("file", options->file, "Experiment file")->required();
  command->add_option("--svg", options->svg, "Picture to write");
  command->add_option("--html", options->html, "Interactive page to write, also of worlds in space");
  command->add_option("--save", options->save, "Roadmap file to write, for planner.roadmap");
  command->add_option("--scen", options->scen, "Check a Moving AI scenario's lengths on the map instead of planning");
  command->add_flag("--json", options->json, "Print one JSON object");
  AddPlace(command, &options->place);
  AddOverrides(command, &options->overrides);
  command->callback([options, commands] { commands->run = [options] { return Plan(*options); }; });
}

void AddEval(CLI::App* app, Commands* commands) {
  auto options = std::make_shared<EvalOptions>();
  CLI::App* command = app->add_subcommand("eval", "Drive the test starts with a run's policy or with pure pursuit");
  command->add_option("run_dir", options->run_dir, "Run directory")->required();
  command->add_option("--trials", options->trials, "Test starts (default: evaluation.test_starts of the experiment)")
      ->check(CLI::Range(1, 100000));
  command->add_option("--seed", options->seed, "Seed of the disturbances (default: the run's)")
      ->check(CLI::Range(int64_t{0}, std::numeric_limits<int64_t>::max()));
  command
      ->add_option("--controller", options->controller,
                   "policy (default) or pure_pursuit; with --conditions both unless one is typed")
      ->check(CLI::IsMember({"policy", "pure_pursuit"}));
  command->add_option("--policy", options->policy, "best or last (default: best if there is one)")
      ->check(CLI::IsMember({"best", "last"}));
  command->add_option("--svg", options->svg, "Picture to write: of the driven paths, or of success under conditions");
  command->add_option("--conditions", options->conditions,
                      "File of conditions (deploy/conditions/stress.textproto) to drive the test starts under");
  command->add_option("--q-map", options->q_map, "Picture of what the critics expect from each place");
  command->add_option("--score-map", options->score_map, "Picture of how soon the goal is reached from each place");
  command->add_option("--height", options->height, "Of maps through a world in space [m] (default: the middle)");
  command->add_option("--html", options->html, "Interactive page of the driven paths to write, also in space");
  command->add_flag("--json", options->json, "Print one JSON object");
  AddOverrides(command, &options->overrides);
  command->callback([options, commands] { commands->run = [options] { return Eval(*options); }; });
}

// Where the robot's messages are, and in which world it is.
template <typename Options>
void AddRobot(CLI::App* command, Options* options) {
  command->add_option("run_dir", options->run_dir, "Run directory")->required();
  command->add_option("--lcm-url", options->lcm_url,
                      "udpm://GROUP:PORT?ttl=T (default: udpm://239.255.76.67:7667?ttl=0)");
  command->add_option("--name", options->name, "Of the robot: its channels are NAME_STATE and NAME_COMMAND")
      ->capture_default_str();
  command->add_option("--map", options->place.map, "Map in the place of the run's world");
  command->add_option("--goal", options->place.goal, "Centre of another goal region, metres in the map's frame")
      ->type_name("X,Y");
  AddOverrides(command, &options->overrides);
}

void AddDrive(CLI::App* app, Commands* commands) {
  auto options = std::make_shared<DriveOptions>();
  CLI::App* command = app->add_subcommand("drive", "Drive a robot with a run's policy");
  AddRobot(command, options.get());
  command->add_option("--policy", options->policy, "best or last (default: best if there is one)")
      ->check(CLI::IsMember({"best", "last"}));
  command->add_option("--timeout", options->timeout, "To arrive within, from the first state on [s] (default: none)")
      ->check(CLI::Range(1e-3, 1e9));
  command->callback([options, commands] { commands->run = [options] { return Drive(*options); }; });
}

void AddStandIn(CLI::App* app, Commands* commands) {
  auto options = std::make_shared<StandInOptions>();
  CLI::App* command =
      app->add_subcommand("robot", "Stand in for a robot, to try cairn drive: simulated, the same messages");
  AddRobot(command, options.get());
  command->add_option("--trial", options->trial, "Test start where it stands at first")
      ->check(CLI::Range(0, 99999))
      ->capture_default_str();
  command->add_option("--speed", options->speed, "Simulated seconds a second; 0: as fast as commands come")
      ->check(CLI::Range(0.0, 1e9))
      ->capture_default_str();
  command->callback([options, commands] { commands->run = [options] { return StandIn(*options); }; });
}

void AddSpy(CLI::App* app, Commands* commands) {
  auto options = std::make_shared<SpyOptions>();
  CLI::App* command = app->add_subcommand("spy", "Watch the messages of a run with lcm-spy");
  command->add_option("run_dir", options->run_dir, "Run directory (default: the transport's default ports)");
  command->add_option("--plane", options->plane, "telemetry (default), experience, control or tables");
  command->callback([options, commands] { commands->run = [options] { return Spy(*options); }; });
}

void AddDoctor(CLI::App* app, Commands* commands) {
  auto options = std::make_shared<DoctorOptions>();
  CLI::App* command = app->add_subcommand("doctor", "Look whether this host, or two of them, can run Cairn");
  command->add_option("subject", options->subject, "Run directory or experiment file (default: the defaults)");
  AddPlace(command, &options->place);
  AddOverrides(command, &options->overrides);
  command->add_option("--lcm-url", options->lcm_url, "Group, first port and ttl, as of cairn actor");
  command->add_option("--key", options->key, "File with the run's key (default: RUN_DIR/key, or key beside the file)");
  command->add_flag("--insecure", options->insecure, "The run does without a key");
  command->add_option("--run-dir", options->run_dir, "Where a run of the file would write (default: here)");
  command->add_flag("--peer", options->peer, "Measure loss and round trip to a host that does the same");
  command->add_option("--probes", options->probes, "Of --peer: datagrams each way, the same on both hosts")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_option("--timeout", options->patience, "Of --peer: how long to wait for it [s]")
      ->check(CLI::Range(1e-3, 1e9))
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print one JSON object");
  command->callback([options, commands] { commands->run = [options] { return Doctor(*options); }; });
}

void AddLog(CLI::App* app, Commands* commands) {
  auto options = std::make_shared<RecordOptions>();
  CLI::App* command = app->add_subcommand("log", "Record a run's messages to an LCM log, without loss");
  command->add_option("run_dir", options->run_dir, "Run directory of a run that goes on");
  command->add_option("--lcm-url", options->lcm_url,
                      "udpm://GROUP:PORT, PORT the first of five, or tcpq://HOST:PORT, instead of a run directory");
  command->add_option("--planes", options->planes, "Which, separated by commas")->capture_default_str();
  command->add_option("--out", options->out, "File to make, for lcm-logplayer and cairn train --replay-log");
  command->add_option("--duration", options->duration_s, "Seconds after which it ends (default: with the run)")
      ->check(CLI::Range(1e-3, 1e9));
  command->callback([options, commands] { commands->run = [options] { return Record(*options); }; });
}

// `cairn actor …` becomes `cairn-actor …`, arguments untouched.
[[noreturn]] void ExecProcess(const std::string& kind, char** arguments) {
  std::string program = SiblingProgram("cairn-" + kind);
  std::vector<char*> argv{program.data()};
  while (*arguments != nullptr) argv.push_back(*arguments++);
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  ThrowError("cannot start {}: {}", program, std::strerror(errno));
}

void AddProcess(CLI::App* app, const std::string& kind, const std::string& description) {
  app->add_subcommand(kind, description);  // listed here; RunCommandLine hands it over before parsing
}

bool IsProcess(const std::string& word) { return word == "planner" || word == "learner" || word == "actor"; }

}  // namespace

int RunCommandLine(int argc, char** argv, int64_t launch_utime_us) {
  if (argc > 1 && IsProcess(argv[1])) ExecProcess(argv[1], argv + 2);
  CLI::App app("Cairn trains navigation policies for cluttered places.", "cairn");
  app.set_version_flag("--version", fmt::format("cairn {} ({})", ProjectVersion(), GitRevision()));
  app.require_subcommand(1);
  Commands commands;
  AddTrain(&app, &commands, launch_utime_us);
  AddEval(&app, &commands);
  AddPlan(&app, &commands);
  AddDrive(&app, &commands);
  AddStandIn(&app, &commands);
  AddSpy(&app, &commands);
  AddDoctor(&app, &commands);
  AddLog(&app, &commands);
  AddProcess(&app, "planner", "Run one planner process (see cairn planner --help)");
  AddProcess(&app, "learner", "Run one learner process (see cairn learner --help)");
  AddProcess(&app, "actor", "Run one actor process (see cairn actor --help)");
  if (!ParseCommandLine(&app, argc, argv)) return 0;
  return commands.run();
}

}  // namespace cairn::deploy
