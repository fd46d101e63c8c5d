#pragma once

#include <vector>

#include "common/world/distance_field.h"
#include "common/world/world.h"

namespace cairn {

/// Flood fill of the free space (field ≥ radius) from the goal region.
class Reachability {
 public:
  /// Throws UsageError ("world.goal …") when no point of the goal region is free for a disc/sphere of `radius` [m].
  Reachability(const World& world, const DistanceField& field, double radius);

  /// True when the goal can be reached from p's grid cell.
  bool Reaches(const Vector3d& p) const;

  /// Throws UsageError when no free point of the start region reaches the goal; names the radius and both regions.
  void CheckStart() const;

 private:
  World world_;
  const DistanceField& field_;
  double radius_;
  double step_;
  Eigen::Vector3i cells_;
  std::vector<char> reached_;
};

}  // namespace cairn
