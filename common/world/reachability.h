#pragma once

#include <vector>

#include "common/world/distance_field.h"
#include "common/world/world.h"

namespace cairn {

/// Flood fill of the free space (field ≥ radius at the field's nodes) from the goal region. Immutable; any thread.
class Reachability {
 public:
  /// `field` must outlive it. Throws UsageError ("world.goal …") when no point of the goal region is free for a
  /// disc/sphere of `radius` [m].
  Reachability(const World& world, const DistanceField& field, double radius);

  /// True when p lies within the bounds and the goal can be reached from a corner of p's grid cell; says nothing
  /// about p itself being free.
  bool Reaches(const Vector3d& p) const;

  /// Throws UsageError when no free point of the start region reaches the goal; names the radius and both regions.
  void CheckStart() const;

  /// The free point of the goal region with the most room, on the grid or a 17-fold division of the region.
  const Vector3d& goal_point() const { return goal_point_; }

 private:
  bool CellCorner(const Vector3d& p, Eigen::Vector3i& corner) const;
  Vector3d NodePosition(const Eigen::Vector3i& node) const { return world_.bounds.min + step_ * node.cast<double>(); }
  size_t Index(const Eigen::Vector3i& node) const {
    return (static_cast<size_t>(node.z()) * nodes_.y() + node.y()) * nodes_.x() + node.x();
  }
  void Seed(const Vector3d& p, std::vector<Eigen::Vector3i>& stack);
  void Visit(const Eigen::Vector3i& node, std::vector<Eigen::Vector3i>& stack);
  void Flood(std::vector<Eigen::Vector3i> stack);

  World world_;
  const DistanceField& field_;
  double radius_;
  double step_;  // between nodes [m]
  Eigen::Vector3i nodes_;
  Vector3d goal_point_;
  std::vector<char> reached_;  // per node
};

}  // namespace cairn
