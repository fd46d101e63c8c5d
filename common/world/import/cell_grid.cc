#include "common/world/import/cell_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/core/check.h"

namespace cairn {
namespace {

struct Span {
  int low, high;  // cells low ≤ i < high
};

// The grid after `quarters` quarter turns counter-clockwise about its origin corner.
CellGrid TurnQuarters(const CellGrid& grid, int quarters) {
  if (quarters == 0) return grid;
  const int w = grid.size.x(), h = grid.size.y();
  CellGrid turned = grid;
  if (quarters % 2 == 1) turned.size = {h, w, 1};
  const double dx[] = {0, -h * grid.cell, -w * grid.cell, 0}, dy[] = {0, 0, -h * grid.cell, -w * grid.cell};
  turned.origin += Vector3d(dx[quarters], dy[quarters], 0);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const std::array<std::array<int, 2>, 4> to{{{x, y}, {h - 1 - y, x}, {w - 1 - x, h - 1 - y}, {y, w - 1 - x}}};
      turned.cells[turned.Index(to[quarters][0], to[quarters][1])] = grid.cells[grid.Index(x, y)];
    }
  }
  return turned;
}

// Axis-aligned box around the turned grid, relative to its origin corner [m].
Box TurnedExtent(const CellGrid& grid, double c, double s) {
  Box box;
  const Vector3d side = grid.cell * grid.size.cast<double>();
  for (const double x : {0.0, side.x()}) {
    for (const double y : {0.0, side.y()}) {
      const Vector3d corner(c * x - s * y, s * x + c * y, 0);
      box.min = box.min.cwiseMin(corner);
      box.max = box.max.cwiseMax(corner);
    }
  }
  return box;
}

// The worst of the cells that the rectangle (in cells of the grid) touches; occupied as soon as it leaves the grid.
Cell WorstWithin(const CellGrid& grid, double min_x, double min_y, double max_x, double max_y) {
  if (!(min_x >= -1e-9 && min_y >= -1e-9 && max_x <= grid.size.x() + 1e-9 && max_y <= grid.size.y() + 1e-9)) {
    return Cell::kOccupied;
  }
  const auto index = [](double u, int count) { return std::clamp(static_cast<int>(std::floor(u)), 0, count - 1); };
  Cell worst = Cell::kFree;
  const int x1 = index(max_x - 1e-9, grid.size.x()), y1 = index(max_y - 1e-9, grid.size.y());
  for (int y = index(min_y + 1e-9, grid.size.y()); y <= y1; ++y) {
    for (int x = index(min_x + 1e-9, grid.size.x()); x <= x1; ++x) {
      worst = std::max(worst, grid.cells[grid.Index(x, y)]);
    }
  }
  return worst;
}

// Marks the cells of a box as free, so that no other box takes them.
void Take(CellGrid& grid, const std::array<Span, 3>& box) {
  for (int z = box[2].low; z < box[2].high; ++z) {
    for (int y = box[1].low; y < box[1].high; ++y) {
      const auto begin = grid.cells.begin() + static_cast<std::ptrdiff_t>(grid.Index(box[0].low, y, z));
      std::fill(begin, begin + (box[0].high - box[0].low), Cell::kFree);
    }
  }
}

bool AllTaken(const CellGrid& grid, const Span& x, const Span& y, const Span& z) {
  for (int k = z.low; k < z.high; ++k) {
    for (int j = y.low; j < y.high; ++j) {
      const auto begin = grid.cells.begin() + static_cast<std::ptrdiff_t>(grid.Index(x.low, j, k));
      const auto end = begin + (x.high - x.low);
      if (std::find(begin, end, Cell::kFree) != end) return false;
    }
  }
  return true;
}

// The largest box from a corner, grown along x, then y, then z.
std::array<Span, 3> Grow(const CellGrid& grid, int x, int y, int z) {
  std::array<Span, 3> box{{{x, x + 1}, {y, y + 1}, {z, z + 1}}};
  while (box[0].high < grid.size.x() && grid.cells[grid.Index(box[0].high, y, z)] != Cell::kFree) ++box[0].high;
  while (box[1].high < grid.size.y() && AllTaken(grid, box[0], {box[1].high, box[1].high + 1}, box[2])) ++box[1].high;
  while (box[2].high < grid.size.z() && AllTaken(grid, box[0], box[1], {box[2].high, box[2].high + 1})) ++box[2].high;
  return box;
}

}  // namespace

void CheckGrid(const std::string& file, const Vector3d& sizes, double cell, const Vector3d& origin, int64_t max_cells) {
  if (!(cell >= kMinCellSize && cell <= kMaxCellSize)) {
    ThrowUsageError("{}: resolution = {} m a cell; it must be from {} to {}: metres, not centimetres or millimetres",
                    file, cell, kMinCellSize, kMaxCellSize);
  }
  const double total = sizes.x() * sizes.y() * sizes.z();
  if (!(sizes.minCoeff() >= 1)) {
    ThrowUsageError("{}: {} x {} cells; there must be at least one", file, sizes.x(), sizes.y());
  }
  for (int k = 0; k < 3; ++k) {
    const double low = origin[k], high = origin[k] + (sizes[k] > 1 || k < 2 ? sizes[k] * cell : 0);
    if (std::isfinite(low) && std::abs(low) <= kMaxCoordinate && std::abs(high) <= kMaxCoordinate) continue;
    ThrowUsageError(
        "{}: {} from {:.10g} to {:.10g} m ({:.10g} cells of {} m); coordinates must stay within ±{:.0f} m: check the "
        "resolution's unit, or subtract an offset from the origin",
        file, "xyz"[k], low, high, sizes[k], cell, kMaxCoordinate);
  }
  if (!(total <= static_cast<double>(max_cells))) {
    ThrowUsageError("{}: {:.10g} x {:.10g} x {:.10g} cells are more than {}; crop the map or make it coarser", file,
                    sizes.x(), sizes.y(), sizes.z(), max_cells);
  }
}

CellGrid Rotate(const CellGrid& grid, double yaw, const std::string& file, int64_t max_cells) {
  const double turns = yaw / (0.5 * std::numbers::pi), quarters = std::round(turns);
  if (std::abs(turns - quarters) < 1e-9) return TurnQuarters(grid, ((static_cast<int>(quarters) % 4) + 4) % 4);

  const double c = std::cos(yaw), s = std::sin(yaw);
  const Box extent = TurnedExtent(grid, c, s);
  CellGrid turned;
  turned.cell = 0.5 * grid.cell;
  if (extent.size().x() * extent.size().y() / (turned.cell * turned.cell) > static_cast<double>(max_cells)) {
    turned.cell = grid.cell;
  }
  const Vector3d sizes(std::ceil(extent.size().x() / turned.cell), std::ceil(extent.size().y() / turned.cell), 1);
  turned.origin = grid.origin + extent.min;
  CheckGrid(file, sizes, turned.cell, turned.origin, max_cells);
  turned.size = sizes.cast<int>();
  turned.cells.resize(static_cast<size_t>(turned.size.x()) * turned.size.y());
  // A cell's square, turned back, lies within `half` of its centre along both axes of the grid.
  const double scale = turned.cell / grid.cell, half = 0.5 * scale * (std::abs(c) + std::abs(s));
  const Vector3d low = extent.min / grid.cell;
  for (int y = 0; y < turned.size.y(); ++y) {
    for (int x = 0; x < turned.size.x(); ++x) {
      const double px = low.x() + (x + 0.5) * scale, py = low.y() + (y + 0.5) * scale;
      const double u = c * px + s * py, v = c * py - s * px;
      turned.cells[turned.Index(x, y)] = WorstWithin(grid, u - half, v - half, u + half, v + half);
    }
  }
  return turned;
}

CellGrid CropToFree(CellGrid grid, const std::optional<Box>& window, int margin, const std::string& file) {
  Eigen::Vector3i first(0, 0, 0), last = grid.size;  // the window in cells
  for (int k = 0; k < 3 && window; ++k) {
    if (k == 2 && (grid.dimension == 2 || window->min.z() == window->max.z())) continue;
    const double low = std::floor((window->min[k] - grid.origin[k]) / grid.cell + 1e-6);
    const double high = std::ceil((window->max[k] - grid.origin[k]) / grid.cell - 1e-6);
    first[k] = static_cast<int>(std::clamp<double>(low, 0, grid.size[k]));
    last[k] = static_cast<int>(std::clamp<double>(high, 0, grid.size[k]));
  }
  Eigen::Vector3i low = last, high = first;  // around the free cells
  for (int z = first.z(); z < last.z(); ++z) {
    for (int y = first.y(); y < last.y(); ++y) {
      for (int x = first.x(); x < last.x(); ++x) {
        if (grid.cells[grid.Index(x, y, z)] != Cell::kFree) continue;
        low = low.cwiseMin(Eigen::Vector3i(x, y, z));
        high = high.cwiseMax(Eigen::Vector3i(x + 1, y + 1, z + 1));
      }
    }
  }
  if ((high - low).minCoeff() <= 0) {
    ThrowUsageError("{}: no cell is free{}; if free cells were saved as unknown, set world.unknown_is_free", file,
                    window ? " within world.bounds" : "");
  }
  for (int k = 0; k < 3; ++k) {
    low[k] = std::max(low[k] - margin, first[k]);
    high[k] = std::min(high[k] + margin, last[k]);
  }
  CellGrid cropped = {grid.dimension, high - low, grid.cell, grid.origin + grid.cell * low.cast<double>(), {}};
  if (grid.dimension == 2) cropped.origin.z() = 0;
  cropped.cells.reserve(static_cast<size_t>(cropped.size.x()) * cropped.size.y() * cropped.size.z());
  for (int z = low.z(); z < high.z(); ++z) {
    for (int y = low.y(); y < high.y(); ++y) {
      const auto begin = grid.cells.begin() + static_cast<std::ptrdiff_t>(grid.Index(low.x(), y, z));
      cropped.cells.insert(cropped.cells.end(), begin, begin + cropped.size.x());
    }
  }
  return cropped;
}

std::vector<Box> MergeBoxes(CellGrid grid) {
  std::vector<Box> boxes;
  for (int z = 0; z < grid.size.z(); ++z) {
    for (int y = 0; y < grid.size.y(); ++y) {
      for (int x = 0; x < grid.size.x(); ++x) {
        if (grid.cells[grid.Index(x, y, z)] == Cell::kFree) continue;
        const std::array<Span, 3> cells = Grow(grid, x, y, z);
        Take(grid, cells);
        Box box;
        for (int k = 0; k < grid.dimension; ++k) {
          box.min[k] = grid.origin[k] + grid.cell * cells[k].low;
          box.max[k] = grid.origin[k] + grid.cell * cells[k].high;
        }
        boxes.push_back(box);
      }
    }
  }
  return boxes;
}

}  // namespace cairn
