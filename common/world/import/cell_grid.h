#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/world/world.h"

namespace cairn {

/// Heights that a robot on the ground may touch [m].
struct Slice {
  double min = 0, max = 0;
};

enum class Cell : uint8_t { kFree, kUnknown, kOccupied };

/// Cubic (in the plane square) cells of a map, axis-aligned in W; what is outside is occupied.
struct CellGrid {
  int dimension = 2;
  Eigen::Vector3i size{0, 0, 1};      ///< cells along x, y, z
  double cell = 0;                    ///< side of a cell [m]
  Vector3d origin{Vector3d::Zero()};  ///< lower corner of the first cell, W [m]
  std::vector<Cell> cells;            ///< [z][y][x], y upwards

  size_t Index(int x, int y, int z = 0) const {
    return (static_cast<size_t>(z) * size.y() + y) * size.x() + static_cast<size_t>(x);
  }
};

/// What a map may measure at most: a file that promises more has other units than Cairn thinks, or lies.
constexpr double kMaxCellSize = 10;     // [m]
constexpr double kMinCellSize = 1e-4;   // [m]
constexpr double kMaxCoordinate = 1e4;  // [m]: a float, as roadmaps hold it, still resolves a millimetre there

/// Checks a header before anything is allocated for it: throws UsageError naming `file` for cells outside
/// [kMinCellSize, kMaxCellSize], corners beyond kMaxCoordinate, no cells or more than `max_cells`. `sizes` are counts
/// of cells, of which doubles hold even absurd ones.
void CheckGrid(const std::string& file, const Vector3d& sizes, double cell, const Vector3d& origin, int64_t max_cells);

/// The grid turned by `yaw` [rad] about its origin corner, cells axis-aligned again. Exact for quarter turns; else
/// cells of half the side (the whole side where `max_cells` asks for it), each occupied or unknown when a cell that it
/// may touch was: what is free was free, and obstacles grow by less than one cell of the map.
CellGrid Rotate(const CellGrid& grid, double yaw, const std::string& file, int64_t max_cells);

/// The part of the grid around its free cells, with `margin` cells of what bounds them, within `window` if there is
/// one (widened to whole cells; equal heights mean all). Throws UsageError naming `file` when no cell is free there.
CellGrid CropToFree(CellGrid grid, const std::optional<Box>& window, int margin, const std::string& file);

/// Boxes (in the plane rectangles) that cover exactly the cells that are not free: greedy, along x, then y, then z.
std::vector<Box> MergeBoxes(CellGrid grid);

}  // namespace cairn
