#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/config/load.h"
#include "common/core/random.h"
#include "common/world/distance_field.h"
#include "common/world/world.h"
#include "planner/planner.h"

namespace cairn::planner {

/// A world with the planner's settings of a recipe that comes with Cairn, and its roadmap.
struct CostWorld {
  World world;
  PlannerConfig config;
  double inscribed = 0;         ///< radius of the robot [m]
  double field_resolution = 0;  ///< [m]

  BuiltRoadmap Build() const { return BuildRoadmap(world, DistanceField(world, field_resolution), config, inscribed); }
};

/// `file` in deploy/experiments with another world seed and further --set.
inline CostWorld RecipeWorld(const std::string& file, int seed, std::vector<std::string> overrides = {}) {
  const std::string path = std::string(CAIRN_SOURCE_DIR) + "/deploy/experiments/" + file;
  overrides.push_back("world.seed=" + std::to_string(seed));
  const Experiment e = LoadExperiment(path, overrides).experiment;
  return {MakeWorld(e.world), e.planner, e.vehicle.inscribed_radius(), e.world.field_resolution};
}

/// A floor of 20 m × 20 m with 16 rooms, doors of 0.9 m and furniture, for a base of the size of a TurtleBot3 Burger.
inline CostWorld RoomsFloor(uint64_t seed) {
  World world;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(20, 20, 0)};
  world.start = {Vector3d(0.2, 0.2, 0), Vector3d(0.8, 0.8, 0)};
  world.goal = {Vector3d(19.2, 19.2, 0), Vector3d(19.7, 19.7, 0)};
  RandomStream random(seed, RandomPurpose::kTest, 77);
  const auto add = [&](double x0, double y0, double x1, double y1) {
    world.boxes.push_back({Vector3d(x0, y0, 0), Vector3d(x1, y1, 0)});
  };
  for (int line = 5; line < 20; line += 5) {
    for (int room = 0; room < 20; room += 5) {
      const double across = room + random.Uniform(0.3, 3.8), along = room + random.Uniform(0.3, 3.8);
      add(line - 0.1, room, line + 0.1, across);
      add(line - 0.1, across + 0.9, line + 0.1, room + 5);
      add(room, line - 0.1, along, line + 0.1);
      add(along + 0.9, line - 0.1, room + 5, line + 0.1);
    }
  }
  for (int i = 0; i < 40; ++i) {
    const double x = random.Uniform(0.8, 18), y = random.Uniform(0.8, 18);
    add(x, y, x + random.Uniform(0.3, 1), y + random.Uniform(0.3, 1));
  }
  constexpr double kRobot = 0.105;  // radius [m]; what follows is derived as docs/recipes.md says
  PlannerConfig config;
  config.eta = 2.3 * kRobot;
  config.radius = 1.2 * kRobot;
  config.min_spacing = 0.5 * config.eta;
  return {world, config, kRobot, 0.1 * kRobot};
}

}  // namespace cairn::planner
