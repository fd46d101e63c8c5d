#include "deploy/robot/drive.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "common/config/lcm_url.h"
#include "common/core/check.h"
#include "common/core/clock.h"
#include "deploy/launcher/supervisor.h"
#include "deploy/launcher/trials.h"
#include "deploy/robot/pilot.h"

namespace cairn::deploy {
namespace {

constexpr auto kLook = std::chrono::milliseconds(20);  // for signals while no state comes
constexpr auto kSay = std::chrono::seconds(1);         // between two lines about the way
constexpr double kEarly = 0.9;                         // of a control period: states that come sooner are not answered
constexpr double kStands = 0.02;                       // of the top speeds

// With goals = ANY and a typed goal D_min keeps the scale that it had in training: that of the world's own goal.
std::shared_ptr<const actors::Scene> MakeScene(const RunDirectory& run, const LoadedExperiment& own,
                                               const DriveOptions& options) {
  const Experiment experiment =
      Pilot::ForPilot(ChangedExperiment(run, own, options.overrides, std::nullopt, options.place));
  const auto scene = MakePlannedScene(experiment, PlanWorld(experiment, experiment.planner));
  if (experiment.goals != Goals::kAny || options.place.goal.empty()) return scene;
  const Experiment home = ChangedExperiment(run, own, options.overrides, std::nullopt, {options.place.map, "", "", ""});
  const double scale = actors::Scene::ScaleOf(*PlanWorld(home, home.planner).MakeLookup());
  return std::make_shared<const actors::Scene>(scene->WithGoal(scene->goal(), scene->shared_lookup(), scale));
}

void Say(const std::string& line) {
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

// One drive: what was heard, what was said about it.
class Trip {
 public:
  Trip(const Experiment& experiment, Pilot* pilot, RobotLink* link)
      : experiment_(experiment), pilot_(*pilot), link_(*link) {}

  // Answers a state; one that comes within a control period of the last answered is left.
  void Answer(const RobotState& state) {
    heard_ = Clock::now();
    silent_ = false;
    if (!begin_) {
      begin_ = heard_;
      begin_utime_ = state.utime;
    }
    const int64_t age = state.utime - answered_utime_;
    const double early = kEarly * 1e6 * experiment_.environment.control_period;
    if (answered_utime_ > 0 && age >= 0 && static_cast<double>(age) < early) return;
    const RobotCommand command = pilot_.Act(state);
    link_.Send(command);
    answered_utime_ = state.utime;
    if (!arrived_) took_ = 1e-6 * static_cast<double>(state.utime - begin_utime_);
    Measure(state);
    Report(state, command);
    arrived_ = arrived_ || command.mode == RobotCommand::Mode::kArrived;
    stands_ = Stands(state);
  }

  // When nothing has come for as long as a command holds.
  void LookForSilence() {
    if (!begin_ || silent_ || SecondsSince(heard_) < pilot_.validity()) return;
    silent_ = true;
    if (!arrived_) Say(fmt::format("no {} for {:.1f} s; waiting", link_.channel(), pilot_.validity()));
  }

  // It stands in the goal region, or is heard no more since it came there.
  bool done() const { return arrived_ && (stands_ || silent_); }
  // Since the first state, by this host's clock [s].
  double seconds() const { return begin_ ? SecondsSince(*begin_) : 0; }
  // To the goal region, by the robot's clock [s].
  double took() const { return took_; }
  double length() const { return length_; }

 private:
  void Measure(const RobotState& state) {
    if (last_)
      length_ += std::hypot(state.pose[0] - (*last_)[0], state.pose[1] - (*last_)[1], state.pose[2] - (*last_)[2]);
    last_ = state.pose;
  }

  bool Stands(const RobotState& state) const {
    const VehicleConfig& vehicle = experiment_.vehicle;
    const auto& [vx, vy, vz, yaw_rate] = state.velocity;
    return std::hypot(vx, vy, vz) < kStands * vehicle.max_speed &&
           std::abs(yaw_rate) < kStands * vehicle.top_yaw_rate();
  }

  // Each new note, and how far it is once a second.
  void Report(const RobotState& state, const RobotCommand& command) {
    if (command.note != note_) {
      note_ = command.note;
      if (!note_.empty() && command.mode == RobotCommand::Mode::kStop) Say("the robot stands still: " + note_);
    }
    if (command.mode != RobotCommand::Mode::kDrive || heard_ - said_ < kSay) return;
    said_ = heard_;
    const std::string way =
        command.way_to_go < 0 ? "the roadmap does not know how far" : fmt::format("{:.2f} m to go", command.way_to_go);
    Say(fmt::format("{:6.1f} s at {:.2f}, {:.2f}, {:.2f}: {}", took_, state.pose[0], state.pose[1], state.pose[2],
                    way));
  }

  const Experiment& experiment_;
  Pilot& pilot_;
  RobotLink& link_;
  std::optional<TimePoint> begin_;
  TimePoint heard_, said_;
  int64_t begin_utime_ = 0, answered_utime_ = 0;
  double took_ = 0;
  std::optional<std::array<double, 4>> last_;
  double length_ = 0;  // of the way, as measured [m]
  std::string note_;
  bool silent_ = false, arrived_ = false, stands_ = false;
};

}  // namespace

RobotAddress ParseRobotAddress(const std::string& lcm_url, const std::string& name) {
  RobotAddress address;
  address.name = name;
  if (lcm_url.empty()) return address;
  const TransportConfig transport = ParseLcmUrl(lcm_url);
  if (!transport.broker.empty()) {
    ThrowUsageError("--lcm-url {}: a robot is driven by udpm://; a broker's delays do not belong in between", lcm_url);
  }
  address.group = transport.group;
  address.port = transport.base_port;
  address.ttl = transport.ttl;
  return address;
}

int Drive(const DriveOptions& options) {
  const RobotAddress address = ParseRobotAddress(options.lcm_url, options.name);
  const RunDirectory run = RunDirectory::Open(options.run_dir);
  const LoadedExperiment own = LoadExperiment(run.experiment_file());
  const RunPolicy policy = OpenPolicy(run, own, options.policy);
  const std::shared_ptr<const actors::Scene> scene = MakeScene(run, own, options);
  Pilot pilot(scene, policy.file);
  SignalEvents signals;
  RobotLink link(address, RobotLink::End::kDriver);
  Say(fmt::format("{} drives whoever sends {} on {}; Ctrl-C stops the robot", policy.name, link.channel(),
                  address.url()));
  Trip trip(scene->experiment(), &pilot, &link);
  while (!trip.done()) {
    if (const int signal = signals.Wait(Duration::zero()); signal != 0) {
      link.Send(pilot.Stop("cairn drive was stopped"));
      return 128 + signal;
    }
    if (const std::optional<RobotState> state = link.WaitForState(kLook)) trip.Answer(*state);
    trip.LookForSilence();
    if (options.timeout > 0 && trip.seconds() > options.timeout) {
      link.Send(pilot.Stop("cairn drive gave up"));
      ThrowError("not there after {:.1f} s", trip.seconds());
    }
  }
  std::string filtered;
  if (pilot.filtered() >= 0) filtered = fmt::format("; the safety filter changed {} commands", pilot.filtered());
  Say(fmt::format("arrived after {:.1f} s, {:.2f} m{}", trip.took(), trip.length(), filtered));
  return 0;
}

}  // namespace cairn::deploy
