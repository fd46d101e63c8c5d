#pragma once

#include <algorithm>
#include <cstdint>
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

  /// Box around all p with Reaches(p), within the bounds.
  Box extent() const;

  /// Share of the field's free nodes from which the goal can be reached.
  double share() const {
    return static_cast<double>(num_reached_) / static_cast<double>(std::max<int64_t>(1, num_free_));
  }

 private:
  bool CellCorner(const Vector3d& p, Eigen::Vector3i& corner) const;
  Vector3d NodePosition(const Eigen::Vector3i& node) const { return world_.bounds.min + step_ * node.cast<double>(); }
  size_t Index(const Eigen::Vector3i& node) const {
    return (static_cast<size_t>(node.z()) * nodes_.y() + node.y()) * nodes_.x() + node.x();
  }
  void Seed(const Vector3d& p, std::vector<Eigen::Vector3i>& front);
  void Visit(const Eigen::Vector3i& node, std::vector<Eigen::Vector3i>& front);
  void Flood(std::vector<Eigen::Vector3i> front);
  template <typename Visitor>
  void ForEachFreeNode(const Visitor& visitor) const;
  [[noreturn]] void ThrowNoRoom(double most_room) const;

  World world_;  // without its obstacles
  const DistanceField& field_;
  double radius_;
  double step_;  // between nodes [m]
  Eigen::Vector3i nodes_;
  Vector3d goal_point_;
  std::vector<char> reached_;               // per node
  Eigen::Vector3i first_, last_;            // corners of the box of nodes that are reached
  int64_t num_free_ = 0, num_reached_ = 0;  // nodes
};

}  // namespace cairn
