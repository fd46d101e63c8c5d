#include "deploy/robot/stand_in.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "actors/command.h"
#include "actors/observation.h"
#include "common/bus/robot_link.h"
#include "common/core/check.h"
#include "common/core/clock.h"
#include "deploy/launcher/supervisor.h"
#include "deploy/launcher/trials.h"
#include "deploy/robot/drive.h"

namespace cairn::deploy {
namespace {

constexpr auto kAnswer = std::chrono::milliseconds(200);  // that a state is sent again after where no clock drives
constexpr int kDenseBeams = 720;
constexpr int kFarewell = 10;  // states at the end for the driver to see it

void Say(const std::string& line) {
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

std::vector<float> MeasureRanges(const actors::Environment& environment, const ScanConfig& scan) {
  const actors::Motion& motion = environment.motion();
  const double c = std::cos(motion.yaw), s = std::sin(motion.yaw);
  const Vector3d p(motion.x + c * scan.mount_x, motion.y + s * scan.mount_x, motion.z);
  actors::RangeFinder finder = environment.Look();
  std::vector<float> ranges;
  const int dimension = environment.scene().experiment().vehicle.dimension();
  for (const Vector3d& beam : actors::BeamDirections(scan, dimension)) {
    const Vector3d direction(c * beam.x() - s * beam.y(), s * beam.x() + c * beam.y(), beam.z());
    ranges.push_back(static_cast<float>(finder.Range(p, direction, scan.range)));
  }
  return ranges;
}

// The simulated robot behind its messages. Time is simulated: states are a control period apart whatever the clock
// says.
class Robot {
 public:
  Robot(std::shared_ptr<const actors::Scene> scene, const ScanConfig& scan, const StandInOptions& options,
        RobotLink* link)
      : environment_(actors::Scene::ForEvaluation(scene)),
        scan_(scan),
        period_(scene->experiment().environment.control_period),
        speed_(options.speed),
        link_(*link),
        utime_(WallUs()),
        next_(Clock::now()) {
    environment_.ResetEvaluation(StartSet::kTest, options.trial, 0);
  }

  const EpisodeResult& episode() const { return environment_.episode(); }
  actors::Pose pose() const { return environment_.pose(); }
  bool told_to_rest() const { return command_ && command_->mode == RobotCommand::Mode::kArrived; }

  // Measures, is told, moves. It stands until the first command comes: the episode has not begun.
  void Step() {
    link_.Send(Measure(environment_, scan_, utime_));
    Listen();
    if (command_ && episode().outcome == Outcome::kRunning) Move();
    utime_ += static_cast<int64_t>(1e6 * period_);
    if (speed_ > 0) KeepPace();
  }

 private:
  // In simulated time a command is heard in the period that it answers, or in a later one.
  void Listen() {
    const Duration wait = speed_ > 0
                              ? std::chrono::duration_cast<Duration>(std::chrono::duration<double>(period_ / speed_))
                              : Duration(kAnswer);
    Hear(link_.WaitForCommand(wait));
  }

  void Hear(std::optional<RobotCommand> command) {
    if (!command) return;
    const auto size = static_cast<size_t>(environment_.scene().experiment().vehicle.action_size());
    const bool sound = command->command.size() == size && std::all_of(command->command.begin(), command->command.end(),
                                                                      [](double c) { return std::isfinite(c); });
    if (!sound)
      return Say(
          fmt::format("refused a command of {} numbers; {} finite ones are wanted", command->command.size(), size));
    command_ = std::move(command);
    heard_utime_ = utime_;
    held_ = true;
  }

  void Move() {
    const VehicleConfig& vehicle = environment_.scene().experiment().vehicle;
    actors::VehicleCommand told = actors::RestCommand(vehicle);
    if (1e-6 * static_cast<double>(utime_ - heard_utime_) < command_->valid) {
      std::copy(command_->command.begin(), command_->command.end(), told.begin());
    } else if (std::exchange(held_, false)) {
      Say(fmt::format("nothing heard for {:.1f} s: standing still", command_->valid));
    }
    std::array<float, kMaxActionSize> action{};
    actors::ToAction(vehicle, told, action.data());
    environment_.Step(action.data());
  }

  // Until the next state is due, hearing what comes meanwhile.
  void KeepPace() {
    next_ += std::chrono::duration_cast<Duration>(std::chrono::duration<double>(period_ / speed_));
    next_ = std::max(next_, Clock::now() - std::chrono::seconds(1));  // what was missed by more is not made up for
    while (Clock::now() < next_) Hear(link_.WaitForCommand(next_ - Clock::now()));
  }

  actors::Environment environment_;
  const ScanConfig scan_;
  const double period_;  // [s]
  const double speed_;
  RobotLink& link_;
  int64_t utime_;
  TimePoint next_;
  std::optional<RobotCommand> command_;
  int64_t heard_utime_ = 0;
  bool held_ = false;  // the last command still counts
};

int Report(const EpisodeResult& episode, const actors::Pose& pose) {
  const std::string where = fmt::format("{:.3f}, {:.3f}, {:.3f}", pose.x, pose.y, pose.z);
  switch (episode.outcome) {
    case Outcome::kGoal:
      Say(fmt::format("reached the goal at {} after {:.1f} s, {:.2f} m", where, episode.duration, episode.path_length));
      return 0;
    case Outcome::kCollision:
      ThrowError("touched something at {} after {:.1f} s", where, episode.duration);
    default:
      ThrowError("ended at {} after {:.1f} s: {}", where, episode.duration, OutcomeName(episode.outcome));
  }
}

}  // namespace

ScanConfig DenseScan(const Experiment& experiment) {
  ScanConfig scan = experiment.vehicle.scan;
  if (experiment.safety.filter == SafetyConfig::Filter::kOff || experiment.vehicle.dimension() == 3) return scan;
  const bool circle = scan.field_of_view > 2 * std::numbers::pi - 1e-6;
  scan.beams = circle ? std::lcm(scan.beams, experiment.safety.beams) : kDenseBeams;
  scan.field_of_view = 2 * std::numbers::pi;
  return scan;
}

RobotState Measure(const actors::Environment& environment, const ScanConfig& scan, int64_t utime) {
  const actors::Pose pose = environment.believed_pose();
  const actors::Motion& motion = environment.motion();
  RobotState state;
  state.utime = utime;
  state.pose = {pose.x, pose.y, pose.z, pose.yaw};
  state.velocity = {motion.vx, motion.vy, motion.vz, motion.yaw_rate};
  state.angle_min = actors::BeamAngle(scan, 0);
  state.angle_step = scan.beams > 1 ? actors::BeamAngle(scan, 1) - state.angle_min : 2 * std::numbers::pi;
  state.ranges = MeasureRanges(environment, scan);
  return state;
}

int StandIn(const StandInOptions& options) {
  const RobotAddress address = ParseRobotAddress(options.lcm_url, options.name);
  const RunDirectory run = RunDirectory::Open(options.run_dir);
  const LoadedExperiment own = LoadExperiment(run.experiment_file());
  Experiment experiment = ChangedExperiment(run, own, options.overrides, std::nullopt, options.place);
  const ScanConfig scan = DenseScan(experiment);
  experiment.observation.pose_filter = 0;  // the filters are the driver's
  experiment.safety.filter = SafetyConfig::Filter::kOff;
  const auto scene = MakePlannedScene(experiment, PlanWorld(experiment, experiment.planner));
  SignalEvents signals;
  RobotLink link(address, RobotLink::End::kRobot);
  Robot robot(scene, scan, options, &link);
  Say(fmt::format("stands at {:.3f}, {:.3f}, {:.3f} and sends to {}; waiting for {}", robot.pose().x, robot.pose().y,
                  robot.pose().z, address.url(), link.channel()));
  int farewell = kFarewell;
  while (farewell > 0) {
    robot.Step();
    if (const int signal = signals.Wait(Duration::zero()); signal != 0) return 128 + signal;
    if (robot.episode().outcome == Outcome::kRunning) continue;
    farewell = robot.told_to_rest() ? 0 : farewell - 1;
  }
  return Report(robot.episode(), robot.pose());
}

}  // namespace cairn::deploy
