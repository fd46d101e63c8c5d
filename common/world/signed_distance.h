#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/world/world.h"

namespace cairn {

/// Distance [m] from p to the surface of the box over the first `dimension` axes, negative inside.
inline double SignedDistance(const Box& box, const Vector3d& p, int dimension) {
  double outside = 0, inside = -std::numeric_limits<double>::infinity();
  for (int k = 0; k < dimension; ++k) {
    const double q = std::max(box.min[k] - p[k], p[k] - box.max[k]);
    if (!(q <= 0)) outside += q * q;  // NaN stays NaN
    inside = std::max(inside, q);
  }
  return outside == 0 ? inside : std::sqrt(outside);
}

/// Distance [m] from p to the surface of the cylinder (dimension 2: of the disc), negative inside.
inline double SignedDistance(const Cylinder& cylinder, const Vector3d& p, int dimension) {
  const double side = std::hypot(p.x() - cylinder.base.x(), p.y() - cylinder.base.y()) - cylinder.radius;
  if (dimension == 2) return side;
  const double face = std::max(cylinder.base.z() - p.z(), p.z() - cylinder.base.z() - cylinder.height);
  if (side > 0 && face > 0) return std::hypot(side, face);
  return std::max(side, face);
}

/// Distance [m] from p to the nearest obstacle or to the outside of the bounds, by visiting all of them. Negative
/// inside: minus the depth below the surface of the obstacle that p is deepest in. 1-Lipschitz in p.
inline double SignedDistance(const World& world, const Vector3d& p) {
  double distance = -SignedDistance(world.bounds, p, world.dimension);
  for (const Box& box : world.boxes) distance = std::min(distance, SignedDistance(box, p, world.dimension));
  for (const Cylinder& cylinder : world.cylinders) {
    distance = std::min(distance, SignedDistance(cylinder, p, world.dimension));
  }
  return distance;
}

}  // namespace cairn
