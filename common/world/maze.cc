// The paper's Car-2D maze. Walls stand on the lines of a (cells + 1)² lattice whose pitch is corridor + wall; a wall
// segment reaches over the posts at both of its ends, so that runs leave no gaps at corners.
#include <cmath>
#include <utility>

#include "common/core/check.h"
#include "common/core/random.h"
#include "common/world/world.h"

namespace cairn {
namespace {

// Which walls stand. Line i of an axis lies below cell i, lines 0 and `cells` are the border.
class WallGrid {
 public:
  explicit WallGrid(int cells) : cells_(cells) {
    for (auto& axis : walls_) axis.assign(static_cast<size_t>(cells + 1) * cells, 1);
  }

  // Wall across `axis` (0: x, 1: y) on `line`, beside cell number `along` of the other axis.
  char& wall(int axis, int line, int along) { return walls_[axis][static_cast<size_t>(line) * cells_ + along]; }
  bool wall(int axis, int line, int along) const {
    return walls_[axis][static_cast<size_t>(line) * cells_ + along] != 0;
  }
  int cells() const { return cells_; }

 private:
  int cells_;
  std::vector<char> walls_[2];
};

struct Cell {
  int x, y;
};

// Opens the wall between a cell and its neighbour in `direction` (0: +x, 1: −x, 2: +y, 3: −y).
void Open(WallGrid& grid, Cell cell, int direction) {
  const int line = (direction < 2 ? cell.x : cell.y) + (direction % 2 == 0 ? 1 : 0);
  grid.wall(direction / 2, line, direction < 2 ? cell.y : cell.x) = 0;
}

Cell Neighbor(Cell cell, int direction) {
  const int step = direction % 2 == 0 ? 1 : -1;
  return direction < 2 ? Cell{cell.x + step, cell.y} : Cell{cell.x, cell.y + step};
}

// Depth-first search with back-tracking from the lower left cell: a spanning tree of the cells.
void CarvePerfectMaze(WallGrid& grid, RandomStream& random) {
  const int n = grid.cells();
  std::vector<char> visited(static_cast<size_t>(n) * n, 0);
  const auto at = [&](Cell c) -> char& { return visited[static_cast<size_t>(c.y) * n + c.x]; };
  std::vector<Cell> stack{{0, 0}};
  at({0, 0}) = 1;
  while (!stack.empty()) {
    int choices[4], count = 0;
    for (int direction = 0; direction < 4; ++direction) {
      const Cell c = Neighbor(stack.back(), direction);
      const bool inside = c.x >= 0 && c.y >= 0 && c.x < n && c.y < n;
      if (inside && !at(c)) choices[count++] = direction;
    }
    if (count == 0) {
      stack.pop_back();
      continue;
    }
    const int direction = choices[random.Below(static_cast<uint32_t>(count))];
    Open(grid, stack.back(), direction);
    stack.push_back(Neighbor(stack.back(), direction));
    at(stack.back()) = 1;
  }
}

// Opens round(fraction · remaining) of the inner walls that still stand, each equally likely.
void OpenLoops(WallGrid& grid, double fraction, RandomStream& random) {
  std::vector<char*> standing;
  for (int axis = 0; axis < 2; ++axis) {
    for (int line = 1; line < grid.cells(); ++line) {
      for (int along = 0; along < grid.cells(); ++along) {
        char& wall = grid.wall(axis, line, along);
        if (wall) standing.push_back(&wall);
      }
    }
  }
  const auto count = static_cast<size_t>(std::lround(fraction * static_cast<double>(standing.size())));
  for (size_t i = 0; i < count; ++i) {  // partial Fisher-Yates
    const auto rest = static_cast<uint32_t>(standing.size() - i);
    std::swap(standing[i], standing[i + random.Below(rest)]);
    *standing[i] = 0;
  }
}

// Distances along an axis: wall lines and cells to metres.
struct Lattice {
  double pitch, wall;

  double center(int line) const { return pitch * line + 0.5 * wall; }
  // Box of the run of walls across `axis` on `line`, cells `first` to `last` (inclusive) of the other axis.
  Box Run(int axis, int line, int first, int last) const {
    Box box;
    box.min[axis] = pitch * line;
    box.max[axis] = pitch * line + wall;
    box.min[1 - axis] = pitch * first;
    box.max[1 - axis] = pitch * (last + 1) + wall;
    return box;
  }
};

// Removes inner walls whose middle lies inside the region (not on its edge).
void ClearRegion(WallGrid& grid, const Lattice& lattice, const Box& region) {
  const double edge = 1e-9 * lattice.pitch;
  for (int axis = 0; axis < 2; ++axis) {
    for (int line = 1; line < grid.cells(); ++line) {
      for (int along = 0; along < grid.cells(); ++along) {
        const double across = lattice.center(line), beside = lattice.center(along) + 0.5 * lattice.pitch;
        const bool inside = across > region.min[axis] + edge && across < region.max[axis] - edge &&
                            beside > region.min[1 - axis] + edge && beside < region.max[1 - axis] - edge;
        if (inside) grid.wall(axis, line, along) = 0;
      }
    }
  }
}

std::vector<Box> MergeRuns(const WallGrid& grid, const Lattice& lattice) {
  std::vector<Box> boxes;
  for (int axis = 0; axis < 2; ++axis) {
    for (int line = 0; line <= grid.cells(); ++line) {
      for (int first = 0; first < grid.cells(); ++first) {
        if (!grid.wall(axis, line, first)) continue;
        int last = first;
        while (last + 1 < grid.cells() && grid.wall(axis, line, last + 1)) ++last;
        boxes.push_back(lattice.Run(axis, line, first, last));
        first = last;
      }
    }
  }
  return boxes;
}

void CheckMaze(const WorldConfig& config, double pitch) {
  if (config.cells < 2) ThrowUsageError("world.cells = {}: must be at least 2", config.cells);
  if (!(config.corridor_width > 0)) ThrowUsageError("world.corridor_width = {}: must be > 0", config.corridor_width);
  if (!(config.wall_thickness > 0)) ThrowUsageError("world.wall_thickness = {}: must be > 0", config.wall_thickness);
  if (!(config.loop_fraction >= 0 && config.loop_fraction <= 1)) {
    ThrowUsageError("world.loop_fraction = {}: must be in [0, 1]", config.loop_fraction);
  }
  const double limit = 0.5 * config.cells * pitch;
  if (!(config.square > 0 && config.square <= limit * (1 + 1e-12))) {
    ThrowUsageError("world.square = {} m: must be in (0, {:.6g}], half of {} cells of {:.6g} m", config.square, limit,
                    config.cells, pitch);
  }
}

}  // namespace

World MakeCarMaze(const WorldConfig& config) {
  const Lattice lattice{config.corridor_width + config.wall_thickness, config.wall_thickness};
  CheckMaze(config, lattice.pitch);
  const double side = lattice.pitch * config.cells + lattice.wall;
  // Squares run between the centre lines of walls, so that two cells of the paper's maze make its 0.32 m.
  const double low = 0.5 * lattice.wall, high = side - low;
  World world;
  world.bounds = {Vector3d::Zero(), Vector3d(side, side, 0)};
  world.start = {Vector3d(low, low, 0), Vector3d(low + config.square, low + config.square, 0)};
  world.goal = {Vector3d(high - config.square, high - config.square, 0), Vector3d(high, high, 0)};

  RandomStream random(config.seed, RandomPurpose::kWorld);
  WallGrid grid(config.cells);
  CarvePerfectMaze(grid, random);
  OpenLoops(grid, config.loop_fraction, random);
  ClearRegion(grid, lattice, world.start);
  ClearRegion(grid, lattice, world.goal);
  world.boxes = MergeRuns(grid, lattice);
  return world;
}

}  // namespace cairn
