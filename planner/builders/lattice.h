#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "common/world/world.h"

namespace cairn::planner {

/// Steps between neighbouring cells, in the plane or in space: step k leads by (k % 3 − 1, k / 3 % 3 − 1, k / 9 − 1)
/// cells along x, y, z. So k and 26 − k are opposite, ascending k is ascending [z][y][x], and 13 leads nowhere.
constexpr int kNumSteps = 27;
constexpr int kNoStep = 13;

inline Eigen::Vector3i StepOffset(int step) { return {step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1}; }
inline int Opposite(int step) { return kNumSteps - 1 - step; }
/// 1, √2 or √3 cells.
inline double StepLength(int step) { return std::sqrt(StepOffset(step).squaredNorm()); }

/// Set of the steps to 4 or 8 (plane), 6 or 26 (space) neighbours, bit k for step k.
uint32_t StepsTo(int neighbors);

/// No corner is cut: `free(offset)` holds for all cells that share a corner or an edge with the step's way, and for
/// the one that it leads to: the box that both ends span, without its beginning.
template <typename Free>
bool StepFree(int step, const Free& free) {
  const Eigen::Vector3i to = StepOffset(step);
  const Eigen::Vector3i low = to.cwiseMin(0), high = to.cwiseMax(0);
  Eigen::Vector3i offset;
  for (offset.z() = low.z(); offset.z() <= high.z(); ++offset.z()) {
    for (offset.y() = low.y(); offset.y() <= high.y(); ++offset.y()) {
      for (offset.x() = low.x(); offset.x() <= high.x(); ++offset.x()) {
        if (!offset.isZero() && !free(offset)) return false;
      }
    }
  }
  return true;
}

/// Cubic (in the plane square) cells over a box, along the axes of W.
class Lattice {
 public:
  /// As many whole cells of side `cell` [m] as fit, in the middle of the bounds. Throws UsageError naming
  /// planner.grid_cell when they are more than 2^27.
  Lattice(const Box& bounds, int dimension, double cell);

  int64_t num_cells() const { return size_.cast<int64_t>().prod(); }
  double cell() const { return cell_; }
  int dimension() const { return dimension_; }

  /// Centre of a cell as a roadmap stores it, a float [m].
  Vector3d Center(const Eigen::Vector3i& cell) const;
  bool Contains(const Eigen::Vector3i& cell) const {
    return (cell.array() >= 0).all() && (cell.array() < size_.array()).all();
  }
  int64_t Index(const Eigen::Vector3i& cell) const {
    return (int64_t{cell.z()} * size_.y() + cell.y()) * size_.x() + cell.x();
  }
  /// What a step adds to a cell's index.
  int64_t Stride(int step) const { return Index(StepOffset(step)); }

  /// Calls visit(cell, index) in ascending order: for all cells, or those that may touch `box`, until it returns true;
  /// returns whether it did.
  template <typename Visit>
  bool Any(const std::optional<Box>& box, const Visit& visit) const {
    const Eigen::Vector3i low = box ? CellAt(box->min) : Eigen::Vector3i(0, 0, 0);
    const Eigen::Vector3i high = box ? CellAt(box->max) : Eigen::Vector3i(size_.array() - 1);
    Eigen::Vector3i cell;
    for (cell.z() = low.z(); cell.z() <= high.z(); ++cell.z()) {
      for (cell.y() = low.y(); cell.y() <= high.y(); ++cell.y()) {
        for (cell.x() = low.x(); cell.x() <= high.x(); ++cell.x()) {
          if (visit(cell, Index(cell))) return true;
        }
      }
    }
    return false;
  }

 private:
  Eigen::Vector3i CellAt(const Vector3d& p) const;

  int dimension_;
  double cell_;
  Vector3d origin_;
  Eigen::Vector3i size_;
};

}  // namespace cairn::planner
