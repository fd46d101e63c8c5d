#pragma once

#include <memory>
#include <string>
#include <vector>

#include "actors/motion.h"
#include "actors/vehicles/vehicle.h"
#include "common/config/experiment.h"
#include "common/world/world.h"

namespace cairn::actors {

/// Way [m] from the command to stand still until the vehicle gets no farther, from steady motion under `command`;
/// measured on the simulated vehicle (some milliseconds).
double StoppingDistance(const Experiment& experiment, const VehicleCommand& command);

/// A place on the way of a vehicle, in the level frame that it had at the beginning (x forward, y left, z up).
struct Place {
  Vector3d p = Vector3d::Zero();  ///< centre [m]
  double cos = 1, sin = 0;        ///< of its turn
  double swept = 0;               ///< no point of the footprint has moved farther since the beginning [m]

  Vector3d ToLocal(const Vector3d& v) const { return {cos * v.x() + sin * v.y(), cos * v.y() - sin * v.x(), v.z()}; }
  Vector3d FromLocal(const Vector3d& v) const { return {cos * v.x() - sin * v.y(), sin * v.x() + cos * v.y(), v.z()}; }
};

/// A vehicle like the filtered one that drives ahead of it: what would come of a command that is followed by standing
/// still? Whatever the vehicle's response (lag, steering that turns, thrust that has to swing round first), the twin
/// has it too. All ways are taken for safety.caution times as long, and for as much longer as safety.stopping_distance
/// is than what the simulated vehicle needs.
class BrakingTwin {
 public:
  explicit BrakingTwin(const Experiment& experiment);

  /// The state to drive on from; `drift` [rad/s] is added to what is commanded of a yaw rate.
  void Follow(const Vehicle& vehicle, double drift);

  /// One place for each physics step of `command` for safety.period, then of standing still until it does, 1 s at
  /// most; valid until the next call.
  const std::vector<Place>& Drive(const VehicleCommand& command);

  /// Yaw rate [rad/s] after `command` for safety.period.
  double YawRateAfter(const VehicleCommand& command);

  /// The command that makes it stand still: against the drift.
  VehicleCommand Rest() const { return WithDrift(rest_, -drift_); }
  /// Whether a yaw rate is among the commands.
  bool drifts() const { return turn_ >= 0; }
  /// Physics steps in safety.period.
  int period() const { return period_; }
  /// Factor of all ways.
  double stretch() const { return stretch_; }

 private:
  VehicleCommand WithDrift(VehicleCommand command, double drift) const;
  void Begin(const VehicleCommand& command);
  void Step();

  std::unique_ptr<Vehicle> vehicle_;
  std::string state_;
  VehicleCommand rest_;
  int turn_;          // command that is a yaw rate; −1: none
  double drift_ = 0;  // [rad/s]
  double rate_;       // of physics [Hz]
  int period_;        // [physics steps]
  double stretch_;    // of ways
  double radius_;     // circumscribed [m]
  double turn_arm_;   // how far a turn by 1 rad moves the footprint's corners [m]
  Motion last_;
  double turned_ = 0;  // since the beginning [rad]
  std::vector<Place> path_;
};

}  // namespace cairn::actors
