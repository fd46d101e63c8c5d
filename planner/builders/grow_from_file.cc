#include <cmath>
#include <string>
#include <utility>

#include "common/core/check.h"
#include "common/core/files.h"
#include "planner/builders/builder.h"
#include "planner/builders/coverage.h"
#include "planner/planner.h"
#include "planner/roadmap_file.h"

namespace cairn::planner {
namespace {

void CheckFits(const SavedRoadmap& saved, const BuildTask& task) {
  const std::string& file = task.config.roadmap;
  const World& world = task.space.world();
  if (saved.roadmap.dimension != world.dimension || saved.world_hash != HashOf(world)) {
    ThrowUsageError("planner.roadmap: {}: it is of another world: bounds and obstacles must be the same", file);
  }
  if (!(std::abs(saved.radius - task.config.radius) <= 1e-9 * saved.radius)) {
    ThrowUsageError("planner.roadmap: {}: it is for planner.radius = {} m, not {} m", file, saved.radius,
                    task.config.radius);
  }
}

}  // namespace

// What depends on eta and the goal is found anew; the file says what is free.
Grown GrowFromFile(const BuildTask& task) {
  const PlannerConfig& config = task.config;
  SavedRoadmap saved = DecodeRoadmap(ReadFile(config.roadmap), config.roadmap);
  CheckFits(saved, task);
  const CostTable table = ComputeCostTable(saved.roadmap, task.space.world(), task.space.world().goal);
  Coverage coverage(task.space, config.r_ball(), kCoverageSamples, config.seed);
  for (int v = 0; v < saved.roadmap.num_places(); ++v) {
    if (std::isfinite(table.cost[v])) coverage.AddVertex(saved.roadmap.position(v));
  }
  if (coverage.share() < config.coverage && !IsPath(saved.kind)) {
    ThrowUsageError(
        "planner.roadmap: {}: it covers {:.5f} of free space within r_ball = eta / 2 = {} m, below "
        "planner.coverage = {}",
        config.roadmap, coverage.share(), config.r_ball(), config.coverage);
  }
  return {std::move(saved.roadmap), saved.samples, coverage.share(), saved.kind};
}

}  // namespace cairn::planner
