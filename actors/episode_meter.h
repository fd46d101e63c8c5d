#pragma once

#include "actors/blob.h"
#include "actors/contact_test.h"
#include "actors/motion.h"
#include "common/rl/episode.h"

namespace cairn::actors {

/// Measures an episode while it runs: way driven, smallest clearance, jerk.
class EpisodeMeter {
 public:
  /// `scene` must outlive it.
  EpisodeMeter(const Scene& scene, const ContactTest& contact);

  /// The vehicle rests at its start.
  void Reset(const Motion& start);

  /// After a physics step that ended in `motion`.
  void AddPhysicsStep(const Motion& motion, double center_distance);

  /// Looks at the clearance now; AddPhysicsStep does so 60 times a second.
  void MeasureClearance(const Motion& motion, double center_distance);

  /// After a whole control step; one that an event cut short has no jerk of its own.
  void AddControlStep(const Motion& motion);

  /// The safety filter changed a command in this control step.
  void AddFilteredStep() { ++numbers_.filtered_steps; }

  /// Touching an obstacle is clearance 0.
  void SetContact() { numbers_.min_clearance = 0; }

  /// Writes path_length, min_clearance, mean_jerk, filtered_steps and duration.
  void Fill(EpisodeResult& result) const;

  void Write(BlobWriter& blob) const { blob.Put(numbers_); }
  void Read(BlobReader& blob) { blob.Get(numbers_); }

 private:
  const Scene& scene_;
  const ContactTest& contact_;
  double time_step_;
  double control_period_;
  int64_t clearance_stride_;  // physics steps between two looks at the clearance
  // All eight bytes wide: no padding, so that equal states give equal blobs.
  struct Numbers {
    double x = 0, y = 0, z = 0;
    double path_length = 0;
    double min_clearance = 0;
    double velocity[2][3] = {};  // in W at the last two ends of control steps, newest first
    double jerk_sum = 0;
    int64_t control_steps = 0;
    int64_t physics_steps = 0;
    int64_t filtered_steps = 0;
  } numbers_;
};

}  // namespace cairn::actors
