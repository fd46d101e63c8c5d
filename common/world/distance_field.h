#pragma once

#include <vector>

#include "common/world/world.h"

namespace cairn {

/// Euclidean distance to the nearest obstacle or to the outside of the bounds [m], negative inside obstacles.
/// Exact at grid nodes; bi-/trilinear between, so the error is below resolution · √dimension / 2 and |gradient| ≤ ~1.
/// Immutable after construction; may be read from any thread.
class DistanceField {
 public:
  /// Throws UsageError when the grid would exceed 2^28 nodes (names the resolution and the smallest that fits).
  DistanceField(const World& world, double resolution);

  /// Distance at p [m]; outside the bounds, minus the distance to them.
  double Distance(const Vector3d& p) const;

  /// True when every point of the segment a–b keeps at least `clearance` [m] (sphere tracing).
  bool SegmentClear(const Vector3d& a, const Vector3d& b, double clearance) const;

  double resolution() const { return resolution_; }
  int dimension() const { return dimension_; }

 private:
  int dimension_;
  double resolution_;
  Vector3d origin_;
  Eigen::Vector3i nodes_;
  Box bounds_;
  std::vector<float> values_;
};

}  // namespace cairn
