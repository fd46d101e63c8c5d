#include "planner/planner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/core/check.h"
#include "common/core/clock.h"
#include "common/world/reachability.h"
#include "planner/builders/builder.h"
#include "planner/collision/free_space.h"
#include "planner/collision/swept_sphere_checker.h"
#include "planner/roadmap_file.h"
#include "planner/through_walls.h"

namespace cairn::planner {
namespace {

// Smallest extent of any obstacle [m], infinite without obstacles.
double ThinnestWall(const World& world) {
  double thinnest = std::numeric_limits<double>::infinity();
  for (const Box& box : world.boxes) {
    for (int k = 0; k < world.dimension; ++k) thinnest = std::min(thinnest, box.size()[k]);
  }
  for (const Cylinder& cylinder : world.cylinders) {
    thinnest = std::min(thinnest, 2 * cylinder.radius);
    if (world.dimension == 3) thinnest = std::min(thinnest, cylinder.height);
  }
  return thinnest;
}

// The largest number of four digits below x > 0.
double FourDigitsBelow(double x) {
  const double unit = std::pow(10, std::floor(std::log10(x)) - 3);
  return (std::ceil(x / unit * (1 - 1e-9)) - 1) * unit;
}

// D(s) reads through a wall when a vertex on its far side (planning radius away) comes within r_ball of a robot that
// touches its near side (inscribed radius away). Necessary only: see CheckCostsBehindWalls.
void CheckConfig(const World& world, const PlannerConfig& config, double inscribed_radius) {
  if (!(config.eta > 0)) ThrowUsageError("planner.eta = {} m: must be > 0", config.eta);
  if (!(config.radius > 0)) ThrowUsageError("planner.radius = {} m: must be > 0", config.radius);
  const double limit = ThinnestWall(world) + config.radius + inscribed_radius;
  if (!world.imported && !(config.r_ball() < limit)) {  // of imported maps see CheckCostsBehindWalls
    ThrowUsageError(
        "planner.eta = {} m: r_ball = eta / 2 must be less than thinnest wall + planner.radius + inscribed radius = "
        "{:.6g} m, or costs are read through walls; the largest eta that passes is {:.6g} m",
        config.eta, limit, FourDigitsBelow(2 * limit));
  }
  const bool space = world.dimension == 3;
  const int neighbors = config.grid_neighbors;
  if (config.kind == PlannerConfig::Kind::kGrid && neighbors != (space ? 6 : 4) && neighbors != (space ? 26 : 8)) {
    ThrowUsageError("planner.grid_neighbors = {}: must be {}", neighbors,
                    space ? "6 or 26 in space" : "4 or 8 in the plane");
  }
  if (!(config.min_spacing >= 0 && config.min_spacing <= config.r_ball())) {
    ThrowUsageError("planner.min_spacing = {} m: must be in [0, {:.6g}] (eta / 2), or vertices cannot cover free space",
                    config.min_spacing, config.r_ball());
  }
}

int CountComponents(const Roadmap& roadmap) {
  std::vector<char> seen(roadmap.num_vertices(), 0);
  std::vector<int32_t> stack;
  int components = 0;
  for (int32_t root = 0; root < roadmap.num_vertices(); ++root) {
    if (seen[root]) continue;
    ++components;
    seen[root] = 1;
    stack.push_back(root);
    while (!stack.empty()) {
      const int32_t v = stack.back();
      stack.pop_back();
      for (int32_t e = roadmap.offsets[v]; e < roadmap.offsets[v + 1]; ++e) {
        const int32_t u = roadmap.neighbors[e];
        if (!seen[u]) stack.push_back(u);
        seen[u] = 1;
      }
    }
  }
  return components;
}

}  // namespace

const char* NameOf(PlannerConfig::Kind kind) {
  constexpr const char* kNames[] = {"RRG", "PRM_STAR", "RRT", "RRT_STAR", "GRID"};
  return kNames[static_cast<int>(kind)];
}

void CheckPlannable(const World& world, const DistanceField& field, const PlannerConfig& config,
                    double inscribed_radius) {
  CheckConfig(world, config, inscribed_radius);
  Reachability(world, field, config.radius).CheckStart();
}

BuiltRoadmap BuildRoadmap(const World& world, const DistanceField& field, const PlannerConfig& config,
                          double inscribed_radius) {
  const TimePoint start = Clock::now();
  CheckConfig(world, config, inscribed_radius);
  const Reachability reachability(world, field, config.radius);
  reachability.CheckStart();
  const SweptSphereChecker checker(world, config.radius);
  const FreeSpace space(world, checker, reachability);
  Grown grown = Grow({space, field, config, reachability.goal_point()});
  BuiltRoadmap built{std::move(grown.roadmap), {}};
  built.info.kind = grown.kind;
  built.info.vertices = built.roadmap.num_vertices();
  built.info.bends = built.roadmap.num_bends;
  built.info.edges = built.roadmap.num_edges();
  built.info.samples = static_cast<int>(grown.samples);
  built.info.coverage = grown.coverage;
  built.info.components = CountComponents(built.roadmap);
  if (!world.walls_overlap && !NoWallIsTooThin(config, inscribed_radius)) {  // spares large maps a table
    CheckCostsBehindWalls(world, field, built.roadmap, ComputeCostTable(built.roadmap, world, world.goal), config,
                          inscribed_radius);
  }
  built.info.build_s = SecondsSince(start);
  return built;
}

std::string SaveRoadmap(const World& world, const PlannerConfig& config, const BuiltRoadmap& built) {
  return EncodeRoadmap({built.info.kind, config.radius, HashOf(world), built.info.samples, built.roadmap});
}

}  // namespace cairn::planner
