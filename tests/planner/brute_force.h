#pragma once

#include <limits>
#include <vector>

#include "common/core/random.h"
#include "common/world/import/cell_grid.h"

namespace cairn::planner {

/// A map of random obstacles: `share` of its cells, single ones.
inline CellGrid RandomCells(const Eigen::Vector3i& size, double share, uint64_t seed) {
  RandomStream random(seed, RandomPurpose::kTest);
  CellGrid grid;
  grid.dimension = size.z() > 1 ? 3 : 2;
  grid.size = size;
  grid.cell = 1;
  for (int i = 0; i < size.prod(); ++i)
    grid.cells.push_back(random.Uniform(0, 1) < share ? Cell::kOccupied : Cell::kFree);
  return grid;
}

/// Shortest lengths from all of `sources` to every cell, in cells: the textbook Dijkstra that looks for the nearest
/// open cell among all of them, written without a look at the planner. `free(x, y, z)` must be false outside.
template <typename Free>
std::vector<double> BruteForceLengths(const Eigen::Vector3i& size, bool diagonal, const std::vector<size_t>& sources,
                                      const Free& free) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<double> length(static_cast<size_t>(size.prod()), kFar);
  std::vector<char> done(length.size(), 0);
  for (const size_t source : sources) length[source] = 0;
  while (true) {
    size_t at = length.size();
    for (size_t i = 0; i < length.size(); ++i) {
      if (!done[i] && length[i] < kFar && (at == length.size() || length[i] < length[at])) at = i;
    }
    if (at == length.size()) return length;
    done[at] = 1;
    const int n = static_cast<int>(at), x = n % size.x(), y = n / size.x() % size.y(), z = n / size.x() / size.y();
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dz = -1; dz <= 1; ++dz) {
          const int axes = std::abs(dx) + std::abs(dy) + std::abs(dz);
          if (axes == 0 || (axes > 1 && !diagonal)) continue;
          const bool open = free(x + dx, y, z) && free(x, y + dy, z) && free(x, y, z + dz) && free(x + dx, y + dy, z) &&
                            free(x + dx, y, z + dz) && free(x, y + dy, z + dz) && free(x + dx, y + dy, z + dz);
          if (!open) continue;
          const size_t to = static_cast<size_t>(((z + dz) * size.y() + y + dy) * size.x() + x + dx);
          length[to] = std::min(length[to], length[at] + std::sqrt(axes));
        }
      }
    }
  }
}

}  // namespace cairn::planner
