#pragma once

#include "common/world/world.h"

namespace cairn::planner {

/// How far p is outside of the box along each axis [m], with sign; 0 along those on which it is not.
inline Vector3d Excess(const Box& box, const Vector3d& p) { return p - p.cwiseMax(box.min).cwiseMin(box.max); }

/// Distance [m] between a box and the segment a–b over all three axes, 0 when they touch. Exact to rounding.
inline double SegmentDistance(const Box& box, const Vector3d& a, const Vector3d& b) {
  // Squared, it is convex along the segment, and a parabola between the parameters at which the segment passes a plane
  // of a face: its slope is linear there. [low, high] closes in on the piece in which the slope changes its sign.
  const Vector3d ab = b - a;
  const auto slope = [&](double t) { return ab.dot(Excess(box, a + t * ab)); };
  double low = 0, high = 1, at_low = slope(0), at_high = slope(1);
  if (at_low >= 0) return Excess(box, a).norm();
  if (at_high <= 0) return Excess(box, b).norm();
  for (int k = 0; k < 3; ++k) {
    for (const double face : {box.min[k], box.max[k]}) {
      const double t = (face - a[k]) / ab[k];
      if (!(t > low && t < high)) continue;  // NaN and infinity, too: the segment runs along the face
      const double here = slope(t);
      (here < 0 ? low : high) = t;
      (here < 0 ? at_low : at_high) = here;
    }
  }
  return Excess(box, a + ab * (low + (high - low) * at_low / (at_low - at_high))).norm();
}

}  // namespace cairn::planner
