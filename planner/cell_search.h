#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/world/import/cell_grid.h"

namespace cairn::planner {

/// A* for a point that steps from centre to centre of a map's free cells and cuts no corner: a diagonal step needs all
/// cells that it touches. Borrows the grid. One thread.
class CellSearch {
 public:
  /// `neighbors` is 4 or 8 (plane), 6 or 26 (space).
  CellSearch(const CellGrid& grid, int neighbors);

  /// Length of the shortest way [cells], exact to rounding; none when there is no way or an end is not free. Both ends
  /// must lie in the grid.
  std::optional<double> Length(const Eigen::Vector3i& from, const Eigen::Vector3i& to);

  bool Free(const Eigen::Vector3i& cell) const {
    return (cell.array() >= 0).all() && (cell.array() < grid_.size.array()).all() &&
           grid_.cells[grid_.Index(cell.x(), cell.y(), cell.z())] == Cell::kFree;
  }

 private:
  struct Item {
    double estimate, cost;
    Eigen::Vector3i cell;
  };
  static bool Later(const Item& a, const Item& b);

  double Estimate(const Eigen::Vector3i& from, const Eigen::Vector3i& to) const;
  void Offer(const Eigen::Vector3i& cell, double cost, const Eigen::Vector3i& to);

  const CellGrid& grid_;
  uint32_t steps_;
  bool diagonal_;
  // Of each cell; what an earlier search left has another number.
  std::vector<double> cost_;
  std::vector<uint32_t> search_;
  uint32_t number_ = 0;
  std::vector<Item> heap_;
};

}  // namespace cairn::planner
