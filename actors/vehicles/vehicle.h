#pragma once

#include <memory>
#include <string>

#include "common/config/experiment.h"
#include "common/core/random.h"

namespace cairn::actors {

/// State of a ground vehicle in W: pose [m, rad] and velocities [m/s, rad/s] in its own frame.
struct GroundState {
  double x = 0, y = 0, yaw = 0;
  double speed = 0;     ///< forward, body x
  double yaw_rate = 0;  ///< about body z
};

/// A simulated vehicle: commands in, state out. A new vehicle is a class of this interface.
class Vehicle {
 public:
  virtual ~Vehicle() = default;

  /// Puts it at rest at a pose; `random` draws this episode's parameter spread (environment.parameter_spread).
  virtual void Reset(double x, double y, double yaw, RandomStream& random) = 0;

  /// Sets the commanded forward speed [m/s] and yaw rate [rad/s], held until the next call.
  virtual void Command(double speed, double yaw_rate) = 0;

  /// Advances one physics step (1 / physics_rate_hz).
  virtual void Step() = 0;

  virtual GroundState state() const = 0;

  /// Exact physics state (bit for bit, positions, rotations, velocities, motor state).
  virtual std::string Save() const = 0;
  virtual void Load(const std::string& blob) = 0;
};

std::unique_ptr<Vehicle> MakeVehicle(const VehicleConfig& vehicle, const EnvironmentConfig& environment);

}  // namespace cairn::actors
