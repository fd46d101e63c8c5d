#include "common/world/cube_maze.h"

#include <algorithm>
#include <queue>

#include "common/core/check.h"
#include "common/core/random.h"
#include "common/world/lattice_maze.h"

namespace cairn {
namespace {

void CheckCube(const WorldConfig& config) {
  const double free = config.room_size - config.wall_thickness;
  if (!(config.wall_thickness > 0 && free > 0)) {
    ThrowUsageError("world.wall_thickness = {} m: must be in (0, {}), below world.room_size", config.wall_thickness,
                    config.room_size);
  }
  const auto check = [&](const char* field, double size) {
    if (!(size > 0 && size <= free * (1 + 1e-12))) {
      ThrowUsageError("{} = {} m: must be in (0, {:.6g}], world.room_size less a wall", field, size, free);
    }
  };
  check("world.door_size", config.door_size);
  check("world.shaft_size", config.shaft_size);
  if (config.floors < 2 && config.rooms < 2) ThrowUsageError("world.floors = 1 with world.rooms = 1: no way to go");
}

// Places tiles (walls and ceilings of one room) as boxes.
class CubeBuilder {
 public:
  CubeBuilder(const WorldConfig& config, World* world) : config_(config), world_(world) {}

  // Wall across `axis` (2: a ceiling) on lattice line `line`; `tile` holds the room's indices, that along `axis`
  // unused.
  void AddTile(int axis, int line, const Eigen::Vector3i& tile, double hole) {
    Box box = TileBox(axis, line, tile);
    if (hole == 0) return Add(box);
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const Box door = Hole(axis, box, tile, hole);
    for (const int side : {0, 1}) {  // beside the hole along u, whole; then along v, between those
      Box part = box;
      (side == 0 ? part.max[u] : part.min[u]) = side == 0 ? door.min[u] : door.max[u];
      Add(part);
    }
    for (const int side : {0, 1}) {
      Box part = box;
      part.min[u] = door.min[u];
      part.max[u] = door.max[u];
      (side == 0 ? part.max[v] : part.min[v]) = side == 0 ? door.min[v] : door.max[v];
      Add(part);
    }
    if (axis != 2) world_->doors.push_back(door);
  }

 private:
  // Reaches half a wall over the lattice's lines, so that no gaps are left at edges.
  Box TileBox(int axis, int line, const Eigen::Vector3i& tile) const {
    const double half = 0.5 * config_.wall_thickness;
    Box box;
    for (int k = 0; k < 3; ++k) {
      const int low = k == axis ? line : tile[k], high = k == axis ? line : tile[k] + 1;
      box.min[k] = std::max(world_->bounds.min[k], low * config_.room_size - half);
      box.max[k] = std::min(world_->bounds.max[k], high * config_.room_size + half);
    }
    return box;
  }

  Box Hole(int axis, const Box& tile_box, const Eigen::Vector3i& tile, double size) const {
    Box door;
    for (int k = 0; k < 3; ++k) {
      const double center = (tile[k] + 0.5) * config_.room_size;
      door.min[k] = k == axis ? tile_box.min[k] : center - 0.5 * size;
      door.max[k] = k == axis ? tile_box.max[k] : center + 0.5 * size;
    }
    return door;
  }

  void Add(const Box& box) {
    if ((box.size().array() > 1e-9 * config_.room_size).all()) world_->boxes.push_back(box);
  }

  const WorldConfig& config_;
  World* world_;
};

void AddWalls(const LatticeMaze& plan, int floor, double door_size, CubeBuilder* builder) {
  for (int axis = 0; axis < 2; ++axis) {
    for (int line = 1; line < plan.size(); ++line) {
      for (int along = 0; along < plan.size(); ++along) {
        Eigen::Vector3i tile(along, along, floor);
        builder->AddTile(axis, line, tile, plan.wall(axis, line, along) ? 0 : door_size);
      }
    }
  }
}

void AddCeiling(int rooms, int floor, LatticeRoom shaft, double shaft_size, CubeBuilder* builder) {
  for (int y = 0; y < rooms; ++y) {
    for (int x = 0; x < rooms; ++x) {
      builder->AddTile(2, floor + 1, {x, y, floor}, x == shaft.x && y == shaft.y ? shaft_size : 0);
    }
  }
}

// The room with the most doors on the way from `start`, the last such in the order of the search.
LatticeRoom FarthestRoom(const LatticeMaze& plan, LatticeRoom start) {
  std::vector<char> seen(static_cast<size_t>(plan.size()) * plan.size(), 0);
  const auto at = [&](LatticeRoom r) -> char& { return seen[static_cast<size_t>(r.y) * plan.size() + r.x]; };
  std::queue<LatticeRoom> open({start});
  at(start) = 1;
  LatticeRoom last = start;
  while (!open.empty()) {
    last = open.front();
    open.pop();
    for (int direction = 0; direction < 4; ++direction) {
      const LatticeRoom next = Neighbor(last, direction);
      if (!plan.Inside(next) || !plan.IsOpen(last, direction) || at(next)) continue;
      at(next) = 1;
      open.push(next);
    }
  }
  return last;
}

}  // namespace

World MakeCubeMaze(const WorldConfig& config) {
  CheckCube(config);
  const double side = config.rooms * config.room_size, height = config.floors * config.room_size;
  World world;
  world.dimension = 3;
  world.walls_overlap = true;
  world.bounds = {Vector3d::Zero(), Vector3d(side, side, height)};
  RandomStream random(config.seed, RandomPurpose::kWorld);
  CubeBuilder builder(config, &world);
  LatticeRoom shaft;
  for (int floor = 0; floor < config.floors; ++floor) {
    LatticeMaze plan(config.rooms);
    plan.CarvePerfect(random);
    plan.OpenLoops(config.loop_fraction, random);
    AddWalls(plan, floor, config.door_size, &builder);
    if (floor + 1 < config.floors) {
      shaft.x = static_cast<int>(random.Below(static_cast<uint32_t>(config.rooms)));
      shaft.y = static_cast<int>(random.Below(static_cast<uint32_t>(config.rooms)));
      AddCeiling(config.rooms, floor, shaft, config.shaft_size, &builder);
      continue;
    }
    const LatticeRoom goal = FarthestRoom(plan, shaft);
    const double half = 0.5 * config.wall_thickness;
    const Vector3d corner = config.room_size * Vector3d(goal.x, goal.y, floor);
    world.goal = {(corner.array() + half).matrix(), (corner.array() + config.room_size - half).matrix()};
  }
  const int start_floors = std::max(1, config.floors - 1);
  world.start = {world.bounds.min, Vector3d(side, side, start_floors * config.room_size)};
  world.start_space = world.start;
  return world;
}

}  // namespace cairn
