#include "planner/builders/builder.h"

#include <ompl/util/Console.h>

#include <algorithm>

#include "common/core/check.h"
#include "common/core/random.h"
#include "planner/builders/taut_ways.h"

namespace cairn::planner {
namespace {

constexpr int kRootSamples = 1000;

Grown Build(const BuildTask& task) {
  switch (task.config.kind) {
    case PlannerConfig::Kind::kPrmStar:
      return GrowPrmStar(task);
    case PlannerConfig::Kind::kRrt:
    case PlannerConfig::Kind::kRrtStar:
      return GrowPath(task);
    case PlannerConfig::Kind::kGrid:
      return GrowGrid(task);
    case PlannerConfig::Kind::kRrg:
      break;
  }
  return GrowRrg(task);
}

}  // namespace

std::vector<Vector3d> ChooseRoots(const BuildTask& task) {
  const World& world = task.space.world();
  const PlannerConfig& config = task.config;
  const double spacing = std::max(config.min_spacing, 0.25 * config.eta);
  RandomStream random(config.seed, RandomPurpose::kPlanner, 2);
  std::vector<Vector3d> roots;
  for (int i = 0; i < kRootSamples; ++i) {
    Vector3d p = RoundToFloat(task.goal_point, world.dimension);
    if (i > 0) {
      for (int k = 0; k < world.dimension; ++k) p[k] = random.Uniform(world.goal.min[k], world.goal.max[k]);
      p = RoundToFloat(p, world.dimension);
    }
    const auto too_near = [&](const Vector3d& root) { return (root - p).norm() < spacing; };
    const bool fits = std::none_of(roots.begin(), roots.end(), too_near);
    if (fits && world.Contains(world.goal, p) && task.space.Contains(p)) roots.push_back(p);
  }
  if (roots.empty()) {
    ThrowUsageError("world.goal: no point of it is free for planner.radius = {} m by exact test", config.radius);
  }
  return roots;
}

void ThrowSampleCap(const PlannerConfig& config, double coverage) {
  ThrowUsageError("planner.max_samples = {}: reached with coverage {:.5f} of free space, below planner.coverage = {}",
                  config.max_samples, coverage, config.coverage);
}

Grown Grow(const BuildTask& task) {
  ompl::msg::setLogLevel(ompl::msg::LOG_WARN);
  if (!task.config.roadmap.empty()) return GrowFromFile(task);
  Grown grown = Build(task);
  grown.kind = task.config.kind;
  const bool random = grown.kind == PlannerConfig::Kind::kRrg || grown.kind == PlannerConfig::Kind::kPrmStar;
  if (random) AddTautWays(task.space, task.config.eta, &grown.roadmap);
  return grown;
}

}  // namespace cairn::planner
