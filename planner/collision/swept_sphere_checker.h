#pragma once

#include "common/world/world.h"
#include "planner/collision/obstacle_buckets.h"

namespace cairn::planner {

/// Exact collision test of a sphere (a disc in the plane) that moves along straight lines among a world's obstacles;
/// the bounds are obstacles too. Boxes are decided by their distance to the line, cylinders in space by FCL, for which
/// the swept sphere is a capsule. Const and without scratch: any thread.
///
/// FCL decided on boxes, too, once: 2 µs a motion, and 20 to 40 where it grazes many walls, as taut ways do. A distance
/// field that answered first where it could prove the answer takes three times as long as the boxes' own distances.
class SweptSphereChecker {
 public:
  /// `radius` [m] > 0.
  SweptSphereChecker(const World& world, double radius);
  SweptSphereChecker(const SweptSphereChecker&) = delete;  // its buckets borrow its world
  SweptSphereChecker& operator=(const SweptSphereChecker&) = delete;

  /// True when the sphere centred at p touches nothing; false for non-finite p.
  bool Free(const Vector3d& p) const;

  /// True when the sphere touches nothing on the way from a to b, both included.
  bool MotionFree(const Vector3d& a, const Vector3d& b) const;

  double radius() const { return radius_; }

 private:
  bool InBounds(const Vector3d& p) const;
  bool TouchesAny(Vector3d a, Vector3d b) const;

  World world_;
  double radius_;
  ObstacleBuckets buckets_;  // of world_
};

}  // namespace cairn::planner
