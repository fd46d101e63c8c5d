#pragma once

#include "actors/vehicles/vehicle.h"

namespace cairn::actors {

/// Rests at a pose with the parameters of a fixed stream.
inline void Reset(Vehicle& vehicle, const Pose& pose = {}) {
  RandomStream random(1, RandomPurpose::kParameters);
  vehicle.Reset(pose, random);
}

inline void Advance(Vehicle& vehicle, int physics_steps) {
  for (int i = 0; i < physics_steps; ++i) vehicle.Step();
}

}  // namespace cairn::actors
