#pragma once

#include <array>

#include "common/config/experiment.h"

namespace cairn::actors {

/// Pose of a vehicle in W: centre [m] and yaw [rad]; z is 0 in the plane.
struct Pose {
  double x = 0, y = 0, yaw = 0;
  double z = 0;
};

/// Motion of a vehicle: pose in W, and velocities [m/s, rad/s] in the level frame that turns with its yaw (x forward, y
/// left, z up). In the plane z and vz are 0. Eight doubles without padding: it goes into blobs as it is.
struct Motion {
  double x = 0, y = 0, z = 0;
  double yaw = 0;
  double vx = 0, vy = 0, vz = 0;
  double yaw_rate = 0;

  Pose pose() const { return {x, y, yaw, z}; }
};

/// What a vehicle is told, in the units and order of VehicleConfig::command_ranges; entries beyond action_size are 0.
using VehicleCommand = std::array<double, kMaxActionSize>;

}  // namespace cairn::actors
