#pragma once

#include "actors/measured_scan.h"
#include "actors/persons.h"
#include "actors/scene.h"
#include "common/core/random.h"

namespace cairn::actors {

/// One look around: ranges as the vehicle's sensors give them, people included, with noise and drop-outs
/// (observation.range_noise, range_dropout). The n-th ray of look k has the same noise whenever it is cast.
class RangeFinder {
 public:
  /// Rays that one look may cast.
  static constexpr uint64_t kMaxRays = 8192;

  /// `scene` and `persons` (which may be null) must outlive it; noise comes from `random`.
  RangeFinder(const Scene& scene, const Persons* persons, const RandomStream& random, uint64_t look);

  /// Without people and noise.
  explicit RangeFinder(const Scene& scene);

  /// What a real robot's sensor saw; `scan` must outlive it.
  RangeFinder(const Scene& scene, const MeasuredScan& scan);

  /// Distance [m] from p along a unit vector of W to what is there, 0 to `max_range`; a lost ray gives `max_range`.
  double Range(const Vector3d& p, const Vector3d& direction, double max_range);

 private:
  double TrueRange(const Vector3d& p, const Vector3d& direction, double max_range) const;

  const Scene& scene_;
  const Persons* persons_;
  const MeasuredScan* scan_ = nullptr;  // in the place of the scene
  double noise_, dropout_;
  RandomStream random_;
};

}  // namespace cairn::actors
