#pragma once

#include <memory>
#include <string>

#include "actors/motion.h"
#include "common/config/experiment.h"
#include "common/core/random.h"

namespace cairn::actors {

/// A simulated vehicle: commands in, motion out. A new vehicle is a class of this interface.
class Vehicle {
 public:
  virtual ~Vehicle() = default;

  /// Puts it at rest at a pose; `random` draws this episode's parameter spread (environment.parameter_spread).
  virtual void Reset(const Pose& pose, RandomStream& random) = 0;

  /// Sets the commands, held until the next call.
  virtual void Command(const VehicleCommand& command) = 0;

  /// Advances one physics step (1 / physics_rate_hz).
  virtual void Step() = 0;

  virtual Motion motion() const = 0;

  /// Whether it lies where it should stand: the environment ends the episode as a collision.
  virtual bool fallen() const { return false; }

  /// Exact physics state (bit for bit, positions, rotations, velocities, motor state).
  virtual std::string Save() const = 0;
  virtual void Load(const std::string& blob) = 0;
};

std::unique_ptr<Vehicle> MakeVehicle(const VehicleConfig& vehicle, const EnvironmentConfig& environment);

}  // namespace cairn::actors
