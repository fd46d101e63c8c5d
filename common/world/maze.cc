// The paper's Car-2D maze. Walls stand on the lines of a (cells + 1)² lattice whose pitch is corridor + wall; a wall
// segment reaches over the posts at both of its ends, so that runs leave no gaps at corners.
#include "common/core/check.h"
#include "common/core/random.h"
#include "common/world/lattice_maze.h"
#include "common/world/world.h"

namespace cairn {
namespace {

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
void ClearRegion(LatticeMaze& grid, const Lattice& lattice, const Box& region) {
  const double edge = 1e-9 * lattice.pitch;
  for (int axis = 0; axis < 2; ++axis) {
    for (int line = 1; line < grid.size(); ++line) {
      for (int along = 0; along < grid.size(); ++along) {
        const double across = lattice.center(line), beside = lattice.center(along) + 0.5 * lattice.pitch;
        const bool inside = across > region.min[axis] + edge && across < region.max[axis] - edge &&
                            beside > region.min[1 - axis] + edge && beside < region.max[1 - axis] - edge;
        if (inside) grid.wall(axis, line, along) = 0;
      }
    }
  }
}

std::vector<Box> MergeRuns(const LatticeMaze& grid, const Lattice& lattice) {
  std::vector<Box> boxes;
  for (int axis = 0; axis < 2; ++axis) {
    for (int line = 0; line <= grid.size(); ++line) {
      for (int first = 0; first < grid.size(); ++first) {
        if (!grid.wall(axis, line, first)) continue;
        int last = first;
        while (last + 1 < grid.size() && grid.wall(axis, line, last + 1)) ++last;
        boxes.push_back(lattice.Run(axis, line, first, last));
        first = last;
      }
    }
  }
  return boxes;
}

// The gaps between the posts of inner walls that are open.
std::vector<Box> Openings(const LatticeMaze& grid, const Lattice& lattice) {
  std::vector<Box> doors;
  for (int axis = 0; axis < 2; ++axis) {
    for (int line = 1; line < grid.size(); ++line) {
      for (int along = 0; along < grid.size(); ++along) {
        if (!grid.wall(axis, line, along)) doors.push_back(lattice.Run(axis, line, along, along));
      }
    }
  }
  return doors;
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
  LatticeMaze grid(config.cells);
  grid.CarvePerfect(random);
  grid.OpenLoops(config.loop_fraction, random);
  ClearRegion(grid, lattice, world.start);
  ClearRegion(grid, lattice, world.goal);
  world.boxes = MergeRuns(grid, lattice);
  world.walls_overlap = true;
  world.doors = Openings(grid, lattice);
  world.start_space = world.bounds;
  return world;
}

}  // namespace cairn
