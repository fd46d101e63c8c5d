#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "actors/measured_scan.h"
#include "actors/observation.h"
#include "actors/rewards/reward.h"
#include "actors/scene.h"
#include "common/bus/messages.h"
#include "common/nn/policy.h"

namespace cairn::deploy {

/// Drives a robot as a policy drives its simulated vehicle: pose, velocity and ranges in, one control period's command
/// out. Keeps what an episode keeps: D_min, the last actions, the filtered pose (observation.pose_filter). One thread.
class Pilot {
 public:
  /// `scene` has the table of the goal; `policy` takes its observations.
  Pilot(std::shared_ptr<const actors::Scene> scene, const PolicyFile& policy);

  /// The command for the control period that begins at `state`: kArrived in the goal region; kStop, with what is wrong
  /// in the note, for a state that is not sound, outside the world, or from where no roadmap leads to the goal. Such
  /// states change nothing.
  RobotCommand Act(const RobotState& state);

  /// The command to stand still.
  RobotCommand Stop(const std::string& note) const;

  /// How long a command holds [s]: three control periods.
  double validity() const;

 private:
  std::string Fault(const RobotState& state) const;
  actors::Pose Believe(const actors::Motion& measured, int64_t utime);
  std::vector<double> Drive(const actors::Motion& motion, const actors::Pose& believed, float distance);

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
};

}  // namespace cairn::deploy
