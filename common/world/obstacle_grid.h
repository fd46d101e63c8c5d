#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "common/world/world.h"

namespace cairn {

/// What a vehicle covers: a plane oriented rectangle, or a disc (in space a sphere) when `radius` > 0.
struct Footprint {
  double half_length = 0;  ///< along body x [m]
  double half_width = 0;   ///< along body y [m]
  double radius = 0;       ///< [m]

  double circumscribed_radius() const { return radius > 0 ? radius : std::hypot(half_length, half_width); }
};

/// Obstacles of a plane world bucketed into square cells for exact near-obstacle queries. Immutable; any thread.
class ObstacleGrid {
 public:
  /// `reach` [m]: queries of `Overlaps` look at obstacles within this distance of the centre.
  ObstacleGrid(const World& world, double reach);

  /// True when the footprint centred at (x, y) with the given yaw [rad] touches an obstacle or leaves the bounds
  /// (separating axes, exact; a disc by distance). The footprint's circumscribed radius must not exceed `reach`.
  bool Overlaps(double x, double y, double yaw, const Footprint& footprint) const;

  /// Distance [m] from (x, y) along the unit direction to the first obstacle or bound, at most `max_range`; 0 inside
  /// an obstacle. Cell walk (DDA) with slab tests.
  double CastRay(double x, double y, double direction_x, double direction_y, double max_range) const;

 private:
  struct Rectangle {
    double min_x, min_y, max_x, max_y;
  };
  struct Disc {
    double x, y, radius;
  };
  struct Ray;
  // Cell → obstacles, CSR. Numbers below rectangles_.size() are rectangles, then come discs.
  struct Buckets {
    std::vector<int32_t> offsets, items;
  };

  bool InBounds(double x, double y) const;
  bool DiscOverlaps(double x, double y, double radius) const;
  int CellOf(double x, double y) const;
  Buckets Fill(double margin) const;
  double Hit(int obstacle, const Ray& ray) const;

  std::vector<Rectangle> rectangles_;
  std::vector<Disc> discs_;
  Rectangle bounds_;
  double reach_;
  double cell_, inverse_cell_;  // side of a cell [m]
  int columns_, rows_;
  Buckets near_;      // obstacles within `reach` of the cell
  Buckets touching_;  // obstacles that intersect the cell
};

}  // namespace cairn
