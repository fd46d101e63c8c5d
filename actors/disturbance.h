#pragma once

#include "actors/blob.h"
#include "common/config/experiment.h"
#include "common/core/random.h"

namespace cairn::actors {

/// What the policy commands: forward speed [m/s] and yaw rate [rad/s].
struct DriveCommand {
  double speed = 0;
  double yaw_rate = 0;
};

/// Disturbance of the command, held for disturbance_hold: v (1 + a n), w + b n' with standard normals n, n'. (White
/// noise per physics step would vanish behind the motors.)
class HeldDisturbance {
 public:
  explicit HeldDisturbance(const EnvironmentConfig& config);

  /// Starts an episode; the numbers come from `random`.
  void Reset(const RandomStream& random);

  /// True when physics step `step` of the episode begins a new hold; draws its numbers.
  bool Advance(int64_t step);

  DriveCommand Apply(const DriveCommand& command) const;

  void Write(BlobWriter& blob) const;
  /// After Reset with the same stream.
  void Read(BlobReader& blob);

 private:
  double speed_gain_, yaw_rate_gain_;
  int64_t hold_steps_;
  RandomStream random_;
  double speed_noise_ = 0, yaw_rate_noise_ = 0;
};

}  // namespace cairn::actors
