#pragma once

#include <span>
#include <vector>

#include "common/world/world.h"

namespace cairn {

/// A plane oriented rectangle: the footprint of a ground vehicle.
struct Footprint {
  double half_length = 0;  ///< along body x [m]
  double half_width = 0;   ///< along body y [m]
};

/// Obstacles bucketed into square cells for exact near-obstacle queries in the plane. Immutable; any thread.
class ObstacleGrid {
 public:
  /// `reach` [m]: queries of `Overlaps` look at obstacles within this distance of the centre.
  ObstacleGrid(const World& world, double reach);

  /// True when the footprint centred at (x, y) with the given yaw [rad] touches an obstacle or leaves the bounds
  /// (separating axes, exact). The footprint's circumscribed radius must not exceed `reach`.
  bool Overlaps(double x, double y, double yaw, const Footprint& footprint) const;

  /// Distance [m] from (x, y) along the unit direction to the first obstacle or bound, at most `max_range`; 0 inside
  /// an obstacle. Cell walk (DDA) with slab tests.
  double CastRay(double x, double y, double direction_x, double direction_y, double max_range) const;

 private:
  const World world_;
  double cell_;
  double reach_;
  int columns_ = 0, rows_ = 0;
  std::vector<int32_t> offsets_, items_;          // CSR: cell → obstacles within `reach` of the cell
  std::vector<int32_t> ray_offsets_, ray_items_;  // CSR: cell → obstacles that intersect it
};

}  // namespace cairn
