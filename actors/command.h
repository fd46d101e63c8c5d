#pragma once

#include "actors/motion.h"
#include "common/config/experiment.h"

namespace cairn::actors {

/// The command that an action in [−1, 1]^action_size means: linear over each command's range, then bent by
/// command_exponent. Entries outside are clamped.
VehicleCommand ToCommand(const VehicleConfig& vehicle, const float* action);

/// Writes the action [action_size] whose command is the nearest to `command`.
void ToAction(const VehicleConfig& vehicle, const VehicleCommand& command, float* action);

/// The command nearest to standing still.
VehicleCommand RestCommand(const VehicleConfig& vehicle);

}  // namespace cairn::actors
