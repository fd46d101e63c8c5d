#pragma once

#include <array>

#include "actors/blob.h"
#include "actors/motion.h"
#include "common/config/experiment.h"
#include "common/core/random.h"

namespace cairn::actors {

/// What a vehicle believes of its pose (observation.pose_noise and its neighbours). It measures the true one plus noise
/// that is new at every control step plus an offset that jumps now and then, and believes that or, with
/// observation.pose_filter, what a complementary filter makes of it and of odometry, which is exact. Numbers are keyed
/// by step: asking twice gives the same.
class Localization {
 public:
  explicit Localization(const Experiment& experiment);

  /// Starts an episode, without an offset; the first belief is the first measurement.
  void Reset(const RandomStream& random);

  /// Control step `step` (1, 2, …) has ended: the offset may jump, and the filter takes in a measurement.
  void Advance(int step);

  /// At the end of control step `step`; 0: at the start.
  Pose Believe(const Pose& pose, int step) const;

  /// Whether belief and truth ever differ.
  bool active() const { return noisy_ || jumps_; }

  void Write(BlobWriter& blob) const { blob.Put(offset_), blob.Put(filtered_); }
  /// After Reset with the same stream.
  void Read(BlobReader& blob) { blob.Get(offset_), blob.Get(filtered_); }

 private:
  using Error = std::array<double, 4>;  // x, y, z, yaw
  Error Measure(int step) const;

  const ObservationConfig& config_;
  int dimension_;
  double jump_probability_;  // per control step
  bool noisy_, jumps_;
  RandomStream random_;
  Error offset_{};
  Error filtered_{};  // error of the filtered belief
};

}  // namespace cairn::actors
