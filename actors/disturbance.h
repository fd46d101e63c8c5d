#pragma once

#include "actors/blob.h"
#include "actors/motion.h"
#include "common/config/experiment.h"
#include "common/core/random.h"

namespace cairn::actors {

/// Disturbance of the command, held for disturbance_hold: each speed v (1 + a n), yaw rate w + b n, a steering angle
/// plus what gives b n at top speed, with a standard normal n for each. (White noise per physics step would vanish
/// behind the motors.) Slip: of each speed and yaw rate a share u · slip is lost, u uniform in [0, 1).
class HeldDisturbance {
 public:
  HeldDisturbance(const EnvironmentConfig& config, const VehicleConfig& vehicle);

  /// Starts an episode; the numbers come from `random`, those of slip from `slip`.
  void Reset(const RandomStream& random, const RandomStream& slip = {0, RandomPurpose::kSlip});

  /// True when physics step `step` of the episode begins a new hold; draws its numbers.
  bool Advance(int64_t step);

  VehicleCommand Apply(const VehicleCommand& command) const;

  void Write(BlobWriter& blob) const;
  /// After Reset with the same streams.
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
  double slip_;
  bool steers_;  // by its last command, which does not slip
  RandomStream random_, slip_random_;
  std::array<double, kMaxActionSize> noise_{};        // gain · n
  std::array<double, kMaxActionSize> kept_{1, 1, 1};  // share that slip leaves
};

}  // namespace cairn::actors
