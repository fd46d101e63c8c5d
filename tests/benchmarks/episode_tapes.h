#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "actors/contact_test.h"
#include "actors/disturbance.h"
#include "actors/scene.h"
#include "actors/vehicles/vehicle.h"

namespace cairn::actors {

/// A scene with a grid roadmap whose points keep `radius` [m] from obstacles.
std::shared_ptr<const Scene> MakeGridScene(const Experiment& experiment, double radius);

/// One training episode as it was driven: enough to drive it again.
struct Tape {
  int episode = 0;
  std::vector<float> actions;  ///< [steps × action_size]
};

/// Episodes driven by pure pursuit with a random action every few steps, so that turns, slips and contacts occur.
std::vector<Tape> RecordTapes(const std::shared_ptr<const Scene>& scene, int episodes);

/// Root mean square of how far velocities are from commands [m/s].
class SpeedError {
 public:
  explicit SpeedError(const VehicleConfig& vehicle) : holonomic_(vehicle.holonomic()) {}
  void Add(const Motion& m, const VehicleCommand& command) {
    const double dx = m.vx - command[0];
    const double dy = holonomic_ ? m.vy - command[1] : 0, dz = holonomic_ ? m.vz - command[2] : 0;
    sum_ += dx * dx + dy * dy + dz * dz;
    ++count_;
  }
  double rms() const { return std::sqrt(sum_ / std::max(1, count_)); }

 private:
  bool holonomic_;
  double sum_ = 0;
  int count_ = 0;
};

/// The cost that no actor can avoid: physics, and after every physics step contact and goal.
class PhysicsAndContact {
 public:
  /// `scene` must outlive it.
  explicit PhysicsAndContact(const Scene& scene);

  /// Drives the tape's episode again; returns physics steps.
  int64_t Play(const Tape& tape);

  /// At the ends of all control steps so far.
  const SpeedError& speed_error() const { return speed_error_; }

 private:
  bool PlayControlStep(const VehicleCommand& command, int64_t& physics_steps);

  const Scene& scene_;
  std::unique_ptr<Vehicle> vehicle_;
  ContactTest contact_;
  HeldDisturbance disturbance_;
  SpeedError speed_error_;
};

}  // namespace cairn::actors
