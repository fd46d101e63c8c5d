#include "tests/planner/cost_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/roadmap/roadmap_lookup.h"
#include "common/world/signed_distance.h"
#include "planner/builders/point_tree.h"
#include "planner/cost_to_go.h"

namespace cairn::planner {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

Vector3d DrawFree(const World& world, double radius, RandomStream& random) {
  while (true) {
    Vector3d p = Vector3d::Zero();
    for (int k = 0; k < world.dimension; ++k) p[k] = random.Uniform(world.bounds.min[k], world.bounds.max[k]);
    if (SignedDistance(world, p) >= radius) return p;
  }
}

PointTree TreeOf(const Roadmap& roadmap) {
  PointTree tree(roadmap.dimension);
  for (int v = 0; v < roadmap.num_vertices(); ++v) tree.Add(roadmap.position(v));
  return tree;
}

// Length of the way from p over a vertex within eta, infinite without one.
double CostFrom(const Vector3d& p, const CostWorld& scene, const StraightWays& ways, const PointTree& tree,
                const CostTable& table) {
  std::vector<int32_t> near;
  tree.Within(p, scene.config.eta, near);
  std::vector<std::pair<double, int32_t>> over;
  for (const int32_t v : near) {
    const Vector3d& q = tree.point(v);
    const bool inside = scene.world.Contains(scene.world.goal, q);
    const double share = inside ? ShareOutside(scene.world.goal, scene.world.dimension, p, q) : 1;
    over.emplace_back(share * (q - p).norm() + table.cost[v], v);
  }
  std::sort(over.begin(), over.end());
  for (const auto& [length, v] : over) {
    if (ways.Clear(p, tree.point(v))) return length;
  }
  return kInfinite;
}

template <typename Truth>
CostError Measure(const CostWorld& scene, const Roadmap& roadmap, int starts, const Truth& truth) {
  const StraightWays ways(scene.world, scene.config.radius);
  const CostTable table = ComputeCostTable(roadmap, scene.world, scene.world.goal);
  const PointTree tree = TreeOf(roadmap);
  RandomStream random(5, RandomPurpose::kTest);
  CostError error{0, 0, -kInfinite, kInfinite};
  while (error.starts < starts) {
    const Vector3d p = DrawFree(scene.world, scene.config.radius, random);
    const double shortest = truth.Length(p);
    if (shortest == 0 || shortest == kInfinite) continue;
    const double longer = CostFrom(p, scene, ways, tree, table) / shortest - 1;
    ++error.starts;
    error.mean += longer / starts;
    error.largest = std::max(error.largest, longer);
    error.smallest = std::min(error.smallest, longer);
  }
  return error;
}

}  // namespace

CostError MeasureCosts(const CostWorld& scene, const Roadmap& roadmap, int starts, double resolution) {
  if (scene.world.dimension == 2) {
    return Measure(scene, roadmap, starts, PlaneTruth(scene.world, scene.config.radius));
  }
  return Measure(scene, roadmap, starts, SpaceTruth(scene.world, scene.config.radius, resolution));
}

int CountReadThroughWalls(const CostWorld& scene, const Roadmap& roadmap, int samples, int* finite) {
  const double r_ball = scene.config.r_ball();
  const CostTable table = ComputeCostTable(roadmap, scene.world, scene.world.goal);
  const RoadmapLookup lookup(roadmap.dimension, roadmap.positions, table, r_ball, roadmap.num_bends);
  const PointTree tree = TreeOf(roadmap);
  const StraightWays line(scene.world, 2e-6);
  RandomStream random(6, RandomPurpose::kTest);
  std::vector<int32_t> near;
  int read = 0;
  *finite = 0;
  for (int i = 0; i < samples; ++i) {
    const Vector3d p = DrawFree(scene.world, scene.inscribed, random);
    const float d = lookup.CostToGo(p);
    if (!std::isfinite(d)) continue;
    ++*finite;
    // Vertices of the same cost that stand in the ball are all asked for one in sight.
    tree.Within(p, r_ball * (1 + 1e-6), near);
    read += std::none_of(near.begin(), near.end(), [&](int32_t v) {
      return v < roadmap.num_places() && table.cost[v] == d && line.Clear(p, tree.point(v));
    });
  }
  return read;
}

}  // namespace cairn::planner
