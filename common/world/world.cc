#include "common/world/world.h"

#include <cmath>
#include <string>

#include "common/core/check.h"
#include "common/world/cube_maze.h"
#include "common/world/signed_distance.h"

namespace cairn {
namespace {

constexpr const char* kAxes = "xyz";

Box ToBox(const BoxConfig& config, int dimension) {
  Box box;
  for (int k = 0; k < dimension; ++k) {
    box.min[k] = config.min[k];
    box.max[k] = config.max[k];
  }
  return box;
}

// Throws when the region is empty, not finite or inside out along an axis.
void CheckExtent(const Box& box, const std::string& field, int dimension) {
  for (int k = 0; k < dimension; ++k) {
    const bool good = std::isfinite(box.min[k]) && std::isfinite(box.max[k]) && box.min[k] < box.max[k];
    if (!good) {
      ThrowUsageError("{}: {} from {} to {} m is empty: min must be finite and below max", field, kAxes[k], box.min[k],
                      box.max[k]);
    }
  }
}

// Throws unless the region lies within the bounds.
void CheckInside(const Box& box, const Box& bounds, const std::string& field, int dimension) {
  for (int k = 0; k < dimension; ++k) {
    if (box.min[k] < bounds.min[k] || box.max[k] > bounds.max[k]) {
      ThrowUsageError("{}: {} from {} to {} m must lie within world.bounds, {} to {} m", field, kAxes[k], box.min[k],
                      box.max[k], bounds.min[k], bounds.max[k]);
    }
  }
}

// Throws when the obstacle does not reach into the bounds. One that crosses the border is fine: maps have such walls.
void CheckReachesIn(const Box& box, const Box& bounds, const std::string& field, int dimension) {
  for (int k = 0; k < dimension; ++k) {
    if (box.max[k] <= bounds.min[k] || box.min[k] >= bounds.max[k]) {
      ThrowUsageError("{}: {} from {} to {} m lies outside world.bounds, {} to {} m", field, kAxes[k], box.min[k],
                      box.max[k], bounds.min[k], bounds.max[k]);
    }
  }
}

World MakeBoxWorld(const WorldConfig& config) {
  World world;
  world.dimension = config.bounds.min[2] < config.bounds.max[2] ? 3 : 2;
  world.bounds = ToBox(config.bounds, world.dimension);
  world.start = ToBox(config.start, world.dimension);
  world.goal = ToBox(config.goal, world.dimension);
  CheckExtent(world.bounds, "world.bounds", world.dimension);
  for (size_t i = 0; i < config.obstacles.size(); ++i) {
    const std::string field = fmt::format("world.obstacles[{}]", i);
    world.boxes.push_back(ToBox(config.obstacles[i], world.dimension));
    CheckExtent(world.boxes.back(), field, world.dimension);
    CheckReachesIn(world.boxes.back(), world.bounds, field, world.dimension);
  }
  world.start_space = world.bounds;
  return world;
}

World MakeWorldOfKind(const WorldConfig& config) {
  switch (config.kind) {
    case WorldConfig::Kind::kCarMaze:
      return MakeCarMaze(config);
    case WorldConfig::Kind::kCubeMaze:
      return MakeCubeMaze(config);
    case WorldConfig::Kind::kBoxes:
      return MakeBoxWorld(config);
    case WorldConfig::Kind::kMap:
      break;
  }
  ThrowUsageError("world.kind = {}: no such world", static_cast<int>(config.kind));
}

}  // namespace

bool World::Contains(const Box& region, const Vector3d& p) const { return SignedDistance(region, p, dimension) <= 0; }

World MakeWorld(const WorldConfig& config) {
  World world = MakeWorldOfKind(config);
  CheckExtent(world.start, "world.start", world.dimension);
  CheckExtent(world.goal, "world.goal", world.dimension);
  CheckInside(world.start, world.bounds, "world.start", world.dimension);
  CheckInside(world.goal, world.bounds, "world.goal", world.dimension);
  return world;
}

}  // namespace cairn
