#include "common/world/world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/core/check.h"
#include "common/world/cube_maze.h"
#include "common/world/import/import_map.h"
#include "common/world/signed_distance.h"

namespace cairn {
namespace {

constexpr const char* kAxes = "xyz";
constexpr double kLeastTolerance = 1e-6;  // of a point inside an obstacle, whose region is not empty [m]

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
  CheckExtent(world.bounds, "world.bounds", world.dimension);
  for (size_t i = 0; i < config.obstacles.size(); ++i) {
    const std::string field = fmt::format("world.obstacles[{}]", i);
    world.boxes.push_back(ToBox(config.obstacles[i], world.dimension));
    CheckExtent(world.boxes.back(), field, world.dimension);
    CheckReachesIn(world.boxes.back(), world.bounds, field, world.dimension);
  }
  for (size_t i = 0; i < config.cylinders.size(); ++i) {
    const std::string field = fmt::format("world.cylinders[{}]", i);
    const CylinderConfig& c = config.cylinders[i];
    const bool space = world.dimension == 3;
    world.cylinders.push_back({Vector3d(c.base[0], c.base[1], space ? c.base[2] : 0), c.radius, space ? c.height : 0});
    const Vector3d half(c.radius, c.radius, 0);
    const Vector3d base = world.cylinders.back().base;
    const Box around{base - half, base + half + Vector3d(0, 0, world.cylinders.back().height)};
    CheckExtent(around, field, world.dimension);
    CheckReachesIn(around, world.bounds, field, world.dimension);
  }
  world.start_space = world.bounds;
  return world;
}

World MakeMapWorld(const WorldConfig& config) {
  CAIRN_CHECK(config.imported != nullptr, "a MAP world comes with its map: see LoadExperiment");
  World world;
  world.dimension = config.imported->dimension;
  world.bounds = config.imported->bounds;
  world.boxes = config.imported->boxes;
  world.cylinders = config.imported->cylinders;
  world.imported = true;
  world.start_space = world.bounds;
  return world;
}

World MakeObstacles(const WorldConfig& config) {
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
  return MakeMapWorld(config);
}

// The region that the config gives as a box or a point; of a maze its own.
void SetRegion(const World& world, const BoxConfig& box, const std::optional<std::array<double, 3>>& point,
               double tolerance, const std::string& field, Box* region) {
  if (box != BoxConfig{}) *region = ToBox(box, world.dimension);
  if (!point) return;
  const Vector3d p((*point)[0], (*point)[1], world.dimension == 3 ? (*point)[2] : 0);
  for (int k = 0; k < world.dimension; ++k) {
    if (p[k] >= world.bounds.min[k] && p[k] <= world.bounds.max[k]) continue;
    ThrowUsageError("{}_point: {} = {} m lies outside the world, {:.6g} to {:.6g} m", field, kAxes[k], p[k],
                    world.bounds.min[k], world.bounds.max[k]);
  }
  *region = RegionAround(world, p, tolerance);
}

// Half the side of the largest square (cube) around p that reaches into no obstacle [m]: the smallest over the
// obstacles of the largest gap along an axis; ≤ 0 inside one. Of a cylinder its box counts.
double SquareRoom(const World& world, const Vector3d& p) {
  double room = std::numeric_limits<double>::infinity();
  const auto leave = [&](const Vector3d& min, const Vector3d& max) {
    double gap = -std::numeric_limits<double>::infinity();
    for (int k = 0; k < world.dimension; ++k) gap = std::max({gap, min[k] - p[k], p[k] - max[k]});
    room = std::min(room, gap);
  };
  for (const Box& box : world.boxes) leave(box.min, box.max);
  for (const Cylinder& c : world.cylinders) {
    const Vector3d half(c.radius, c.radius, 0);
    leave(c.base - half, c.base + half + Vector3d(0, 0, c.height));
  }
  return room;
}

}  // namespace

bool World::Contains(const Box& region, const Vector3d& p) const { return SignedDistance(region, p, dimension) <= 0; }

Box RegionAround(const World& world, const Vector3d& point, double tolerance) {
  const double half = std::min(std::max(SquareRoom(world, point), kLeastTolerance), tolerance);
  Box region;
  for (int k = 0; k < world.dimension; ++k) {
    region.min[k] = std::max(point[k] - half, world.bounds.min[k]);
    region.max[k] = std::min(point[k] + half, world.bounds.max[k]);
  }
  return region;
}

World MakeWorld(const WorldConfig& config) {
  World world = MakeObstacles(config);
  if (config.kind == WorldConfig::Kind::kMap) {
    world.start = world.bounds;
    if (config.goal == BoxConfig{} && !config.goal_point) {
      ThrowUsageError(
          "world.goal is missing: give it as --goal X,Y; `cairn plan` with --svg draws the map with a grid to read it "
          "from");
    }
  }
  SetRegion(world, config.start, config.start_point, config.point_tolerance, "world.start", &world.start);
  SetRegion(world, config.goal, config.goal_point, config.point_tolerance, "world.goal", &world.goal);
  CheckExtent(world.start, "world.start", world.dimension);
  CheckExtent(world.goal, "world.goal", world.dimension);
  CheckInside(world.start, world.bounds, "world.start", world.dimension);
  CheckInside(world.goal, world.bounds, "world.goal", world.dimension);
  return world;
}

World MakeWorldWithoutGoal(const WorldConfig& config) {
  World world = MakeObstacles(config);
  world.start = world.goal = world.bounds;
  return world;
}

}  // namespace cairn
