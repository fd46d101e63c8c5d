#include "actors/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/check.h"

namespace cairn::actors {
namespace {

// Free space left between the footprint's circle and obstacles at a start, in circumscribed radii: 3 mm for the
// paper's car (radius 43 mm), so that a start is never a graze.
constexpr double kStartMargin = 3.0 / 43.0;

// Tries for one start; a world with less than one free point in a hundred thousand is refused.
constexpr int kMaxDraws = 1000000;

int ControlPhysicsSteps(const EnvironmentConfig& config) {
  return std::max(1, static_cast<int>(std::lround(config.control_period * config.physics_rate_hz)));
}

RandomPurpose StartPurpose(StartSet set) {
  switch (set) {
    case StartSet::kConsumption:
      return RandomPurpose::kConsumptionStart;
    case StartSet::kValidation:
      return RandomPurpose::kValidationStart;
    case StartSet::kTest:
      return RandomPurpose::kTestStart;
    case StartSet::kTraining:
      break;
  }
  return RandomPurpose::kStart;
}

}  // namespace

Scene::Scene(Experiment experiment)
    : experiment_(std::move(experiment)),
      control_physics_steps_(ControlPhysicsSteps(experiment_.environment)),
      world_(MakeWorld(experiment_.world)),
      field_(world_, experiment_.world.field_resolution),
      obstacles_(world_, 1.01 * experiment_.vehicle.circumscribed_radius()),
      reachability_(world_, field_, experiment_.planner.radius) {
  reachability_.CheckStart();
}

void Scene::SetTable(std::shared_ptr<const RoadmapLookup> lookup) {
  CAIRN_CHECK(lookup != nullptr);
  // At least r_ball, so that a table whose vertices all lie in the goal divides nothing by 0.
  if (lookup_ == nullptr) d_min_scale_ = std::max<double>(lookup->table().max_cost(), lookup->r_ball());
  lookup_ = std::move(lookup);
}

Pose Scene::TrainingStart(int vehicle, int episode) const {
  RandomStream random(experiment_.seed, RandomPurpose::kStart, static_cast<uint32_t>(vehicle),
                      static_cast<uint32_t>(episode));
  const bool anywhere = experiment_.environment.start == EnvironmentConfig::Start::kUniform;
  return DrawStart(random, anywhere ? world_.bounds : world_.start);
}

Pose Scene::EvaluationStart(StartSet set, int index) const {
  CAIRN_CHECK(set != StartSet::kTraining);
  RandomStream random(experiment_.world.seed, StartPurpose(set), static_cast<uint32_t>(index));
  return DrawStart(random, world_.bounds);
}

Pose Scene::DrawStart(RandomStream& random, const Box& region) const {
  const double clearance = experiment_.vehicle.circumscribed_radius() * (1 + kStartMargin);
  for (int draw = 0; draw < kMaxDraws; ++draw) {
    const double x = random.Uniform(region.min.x(), region.max.x());
    const double y = random.Uniform(region.min.y(), region.max.y());
    const Vector3d p(x, y, 0);
    if (world_.Contains(world_.goal, p) || field_.Distance(p) < clearance || !reachability_.Reaches(p)) continue;
    return {x, y, random.Uniform(-std::numbers::pi, std::numbers::pi)};
  }
  ThrowUsageError("vehicle.length {}, vehicle.width {}: no free start found among {} draws in x {}..{} m, y {}..{} m",
                  experiment_.vehicle.length, experiment_.vehicle.width, kMaxDraws, region.min.x(), region.max.x(),
                  region.min.y(), region.max.y());
}

}  // namespace cairn::actors
