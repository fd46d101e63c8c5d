#pragma once

#include "actors/blob.h"
#include "actors/motion.h"
#include "common/config/experiment.h"
#include "common/core/random.h"

namespace cairn::actors {

/// Disturbance of the command, held for disturbance_hold: each speed v (1 + a n), yaw rate w + b n, a steering angle
/// plus what gives b n at top speed, with a standard normal n for each. (White noise per physics step would vanish
/// behind the motors.)
class HeldDisturbance {
 public:
  HeldDisturbance(const EnvironmentConfig& config, const VehicleConfig& vehicle);

  /// Starts an episode; the numbers come from `random`.
  void Reset(const RandomStream& random);

  /// True when physics step `step` of the episode begins a new hold; draws its numbers.
  bool Advance(int64_t step);

  VehicleCommand Apply(const VehicleCommand& command) const;

  void Write(BlobWriter& blob) const;
  /// After Reset with the same stream.
  void Read(BlobReader& blob);

 private:
  // How noise n changes a command: command · (1 + gain n), or command + gain n.
  struct Effect {
    bool relative = false;
    double gain = 0;
  };
  int num_commands_;
  std::array<Effect, kMaxActionSize> effects_;
  int64_t hold_steps_;
  RandomStream random_;
  std::array<double, kMaxActionSize> noise_{};  // gain · n
};

}  // namespace cairn::actors
