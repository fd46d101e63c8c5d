#pragma once

#include <vector>

#include "actors/blob.h"
#include "actors/motion.h"
#include "common/config/experiment.h"
#include "common/core/random.h"

namespace cairn::actors {

/// Commands on their way to the vehicle: environment.action_delay_steps control steps, and action_delay to the nearest
/// physics step. Until the first one arrives the vehicle is told to stand still.
class CommandDelay {
 public:
  /// A control step has `control_steps` physics steps.
  CommandDelay(const Experiment& experiment, int control_steps);

  /// Starts an episode; draws its delay from `parameters` when there is a spread.
  void Reset(RandomStream& parameters);

  /// The command given at the beginning of control step `step` (0, 1, …).
  void Push(int step, const VehicleCommand& command);

  /// Number of the command in force in physics step `i` of control step `step`: of the control step that gave it, −1
  /// before the first.
  int InForce(int step, int i) const;

  const VehicleCommand& command(int number) const;

  void Write(BlobWriter& blob) const;
  void Read(BlobReader& blob);

 private:
  size_t Slot(int number) const { return static_cast<size_t>(number) % ring_.size(); }

  const EnvironmentConfig& config_;
  int64_t control_steps_;
  VehicleCommand rest_;
  int64_t delay_ = 0;
  std::vector<VehicleCommand> ring_;  // as many as can be on their way at once
};

}  // namespace cairn::actors
