#pragma once

#include <cstdint>
#include <vector>

#include "common/world/world.h"

namespace cairn {

/// Obstacles of a world in space bucketed into cubic cells for exact near-obstacle queries, the ObstacleGrid of three
/// dimensions. Immutable; any thread.
class SpaceObstacles {
 public:
  /// `reach` [m]: queries of `Overlaps` look at obstacles within this distance of the centre.
  SpaceObstacles(const World& world, double reach);

  /// True when the sphere touches an obstacle or leaves the bounds (exact). `radius` must not exceed `reach`.
  bool Overlaps(const Vector3d& center, double radius) const;

  /// Distance [m] from p along the unit direction to the first obstacle or bound, at most `max_range`; 0 inside an
  /// obstacle. Cell walk (DDA) with exact tests.
  double CastRay(const Vector3d& p, const Vector3d& direction, double max_range) const;

 private:
  struct Ray;
  // Cell → obstacles, CSR. Numbers below boxes_.size() are boxes, then come cylinders.
  struct Buckets {
    std::vector<int32_t> offsets, items;
  };

  bool InBounds(const Vector3d& p, double margin) const;
  int CellIndex(int axis, double coordinate) const;
  int CellOf(const Eigen::Vector3i& cell) const { return (cell.z() * cells_.y() + cell.y()) * cells_.x() + cell.x(); }
  Buckets Fill(double margin) const;
  double Hit(int obstacle, const Ray& ray) const;

  std::vector<Box> boxes_;
  std::vector<Cylinder> cylinders_;
  Box bounds_;
  double reach_;
  double cell_, inverse_cell_;  // side of a cell [m]
  Eigen::Vector3i cells_;       // per axis
  Buckets near_;                // obstacles within `reach` of the cell
  Buckets touching_;            // obstacles that intersect the cell
};

}  // namespace cairn
