#pragma once

#include <vector>

#include "common/world/world.h"

namespace cairn {

/// Euclidean distance to the nearest obstacle or to the outside of the bounds [m], negative inside obstacles: minus the
/// depth in one of them, in imported maps in all of them together.
/// Exact (to float) at grid nodes; bi-/trilinear between, so the error is below interpolation_error() and
/// |gradient| ≤ ~1. Immutable after construction; may be read from any thread.
class DistanceField {
 public:
  /// Throws UsageError when the grid would exceed 2^28 nodes (names the resolution and the smallest that fits).
  DistanceField(const World& world, double resolution);

  /// Distance at p [m]; outside the bounds, minus the distance to them.
  double Distance(const Vector3d& p) const;

  /// True when every point of the segment a–b keeps at least `clearance` [m] (sphere tracing on the interpolated
  /// field). With clearance = c + interpolation_error() + smallest_step() / 2 the true distance is certainly ≥ c all
  /// along.
  bool SegmentClear(const Vector3d& a, const Vector3d& b, double clearance) const;

  double resolution() const { return resolution_; }
  int dimension() const { return dimension_; }
  /// Largest difference between Distance and the true distance [m]: resolution · √dimension / 2.
  double interpolation_error() const;
  /// Sphere tracing never advances by less [m].
  double smallest_step() const { return 0.25 * resolution_; }

 private:
  class Filler;

  int dimension_;
  double resolution_;
  double inverse_resolution_;
  Vector3d origin_;
  Eigen::Vector3i nodes_;  // per axis; z is 1 in the plane
  Box bounds_;
  std::vector<float> values_;  // [z][y][x]
};

}  // namespace cairn
