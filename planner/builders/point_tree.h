#pragma once

#include <cstdint>
#include <vector>

#include "common/world/world.h"

namespace cairn::planner {

/// A k-d tree that grows a point at a time, over the first `dimension` coordinates. Never rebalanced: sampled points
/// come in random order, which keeps its depth near 2 log2(n). Ties go to the point added first.
class PointTree {
 public:
  explicit PointTree(int dimension) : dimension_(dimension) {}

  /// Adds a point; its number is the count of points before it.
  void Add(const Vector3d& p);

  /// Number of the nearest point, −1 when there is none.
  int Nearest(const Vector3d& p) const;

  /// Whether a point is nearer to p than `radius` [m]: several times faster than Nearest where one is.
  bool AnyNearer(const Vector3d& p, double radius) const;

  /// Replaces `found` by the numbers of all points within `radius` [m] of p (edge included), ascending.
  void Within(const Vector3d& p, double radius, std::vector<int32_t>& found) const;

  int size() const { return static_cast<int>(nodes_.size()); }
  const Vector3d& point(int number) const { return nodes_[number].point; }
  void Clear() { nodes_.clear(); }

 private:
  struct Node {
    Vector3d point;
    int32_t axis;
    int32_t child[2];  // below, not below; −1: none
  };

  double SquaredDistance(const Vector3d& a, const Vector3d& b) const;

  int dimension_;
  std::vector<Node> nodes_;
  mutable std::vector<int32_t> stack_;  // scratch of the queries
};

}  // namespace cairn::planner
