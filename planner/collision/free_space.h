#pragma once

#include <optional>

#include "common/core/random.h"
#include "common/world/reachability.h"
#include "common/world/world.h"
#include "planner/collision/swept_sphere_checker.h"

namespace cairn::planner {

/// The part of a region in which the robot's sphere is free and from which the goal can be reached; borrows all that
/// it is made from.
class FreeSpace {
 public:
  FreeSpace(const World& world, const SweptSphereChecker& checker, const Reachability& reachability);

  bool Contains(const Vector3d& p) const { return reachability_.Reaches(p) && checker_.Free(p); }

  /// Uniform point of the free part of `region`, rounded to float as roadmaps store it. None when 10 million tries
  /// found no free point.
  std::optional<Vector3d> Draw(const Box& region, RandomStream& random) const;

  /// Uniform point of all free space, likewise.
  std::optional<Vector3d> Draw(RandomStream& random) const { return Draw(region_, random); }

  const World& world() const { return world_; }
  const SweptSphereChecker& checker() const { return checker_; }

 private:
  const World& world_;
  const SweptSphereChecker& checker_;
  const Reachability& reachability_;
  Box region_;  // that free space lies in
};

/// p as a roadmap stores it; z = 0 in the plane.
Vector3d RoundToFloat(const Vector3d& p, int dimension);

}  // namespace cairn::planner
