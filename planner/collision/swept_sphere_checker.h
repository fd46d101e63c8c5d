#pragma once

#include <memory>

#include "common/world/distance_field.h"
#include "common/world/world.h"

namespace cairn::planner {

/// Exact collision test of a sphere (a disc in the plane) that moves along straight lines among a world's obstacles;
/// the bounds are obstacles too. FCL decides: the swept sphere is a capsule. A distance field, when given, answers
/// first where it can prove the answer, which changes nothing but the time. One thread at a time.
class SweptSphereChecker {
 public:
  /// `radius` [m] > 0. `field`, if any, must be of the same world and outlive the checker.
  SweptSphereChecker(const World& world, double radius, const DistanceField* field = nullptr);
  ~SweptSphereChecker();

  /// True when the sphere centred at p touches nothing; false for non-finite p.
  bool Free(const Vector3d& p) const;

  /// True when the sphere touches nothing on the way from a to b, both included.
  bool MotionFree(const Vector3d& a, const Vector3d& b) const;

  double radius() const { return radius_; }

 private:
  enum class Proof { kFree, kHit, kNone };
  struct Fcl;
  struct Tree;
  struct Buckets;

  static std::unique_ptr<Fcl> MakeFcl(const World& world, double radius);
  Proof Trace(const Vector3d& a, const Vector3d& b) const;
  bool InBounds(const Vector3d& p) const;

  int dimension_;
  double radius_;
  Box bounds_;
  const DistanceField* field_;
  std::unique_ptr<Fcl> fcl_;
};

}  // namespace cairn::planner
