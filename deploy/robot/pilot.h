#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "actors/measured_scan.h"
#include "actors/observation.h"
#include "actors/rewards/reward.h"
#include "actors/safety/safety_filter.h"
#include "actors/scene.h"
#include "actors/vehicles/vehicle.h"
#include "common/bus/messages.h"
#include "common/nn/policy.h"

namespace cairn::deploy {

/// Drives a robot as a policy drives its simulated vehicle: pose, velocity and ranges in, one control period's command
/// out. Keeps what an episode keeps: D_min, the last actions, the filtered pose (observation.pose_filter), and, where
/// safety.filter is not OFF, the safety filter with a simulated vehicle that is told what the robot is told, by whose
/// response it foresees the robot's. One thread.
class Pilot {
 public:
  /// `scene` has the table of the goal and was made of ForPilot(experiment); `policy` takes its observations.
  Pilot(std::shared_ptr<const actors::Scene> scene, const PolicyFile& policy);

  /// The experiment with a safety filter that looks as often as the robot is told something. Throws UsageError for a
  /// filter of what flies: its scan is not dense enough.
  static Experiment ForPilot(Experiment experiment);

  /// The command for the control period that begins at `state`: kArrived in the goal region; kStop, with what is wrong
  /// in the note, for a state that is not sound, outside the world, or from where no roadmap leads to the goal. Such
  /// states change nothing.
  RobotCommand Act(const RobotState& state);

  /// The command to stand still.
  RobotCommand Stop(const std::string& note) const;

  /// How long a command holds [s]: three control periods.
  double validity() const;

  /// Commands so far that the safety filter has changed; −1 without one.
  int64_t filtered() const { return filter_ ? num_filtered_ : -1; }

 private:
  std::string Fault(const RobotState& state) const;
  actors::Pose Believe(const actors::Motion& measured, int64_t utime);
  std::vector<double> Drive(const actors::Motion& motion, const actors::Pose& believed, float distance);
  void MoveTwin(int64_t utime);
  actors::VehicleCommand Filter(const actors::VehicleCommand& command, const actors::Motion& motion);

  std::shared_ptr<const actors::Scene> scene_;
  Policy policy_;
  actors::ObservationBuilder builder_;
  std::unique_ptr<actors::Reward> reward_;
  actors::MeasuredScan scan_;
  struct Belief {
    actors::Motion motion;  // with the believed pose
    int64_t utime = 0;
  };
  std::optional<Belief> belief_;
  float d_min_ = kUnreachable;
  std::vector<float> last_actions_;  // newest first
  std::vector<float> observation_, action_;

  std::optional<actors::SafetyFilter> filter_;
  std::unique_ptr<actors::Vehicle> twin_;  // told what the robot was told
  int64_t twin_utime_ = 0;                 // of the state that its last command answered; 0: it stands
  int64_t twin_steps_ = 0;                 // [physics steps]
  int64_t num_filtered_ = 0;
};

}  // namespace cairn::deploy
