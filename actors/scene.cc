#include "actors/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/check.h"
#include "common/world/world_variants.h"

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

Footprint MakeFootprint(const VehicleConfig& vehicle) {
  if (vehicle.radius > 0) return {0, 0, vehicle.radius};
  return {0.5 * vehicle.length, 0.5 * vehicle.width, 0};
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
      footprint_(MakeFootprint(experiment_.vehicle)) {
  const WorldVariants variants = MakeWorldVariants(experiment_);
  const double reach = 1.01 * footprint_.circumscribed_radius();
  const auto make = [&](const World& world) { return std::make_shared<const Site>(world, experiment_, reach); };
  site_ = make(variants.training);
  known_site_ = variants.same ? site_ : make(variants.known);
  evaluation_site_ = variants.same ? site_ : make(variants.evaluation);
}

Scene::Site::Site(const World& w, const Experiment& experiment, double reach)
    : world(w), field(world, experiment.world.field_resolution), reachability(world, field, experiment.planner.radius) {
  if (world.dimension == 2) obstacles.emplace(world, reach);
  if (world.dimension == 3) space_obstacles.emplace(world, reach);
  reachability.CheckStart();
}

std::shared_ptr<const Scene> Scene::ForEvaluation(const std::shared_ptr<const Scene>& scene) {
  if (scene->site_ == scene->evaluation_site_) return scene;
  const std::shared_ptr<Scene> evaluation(new Scene(*scene));
  evaluation->site_ = scene->evaluation_site_;
  return evaluation;
}

void Scene::SetTable(std::shared_ptr<const RoadmapLookup> lookup) {
  CAIRN_CHECK(lookup != nullptr);
  // At least r_ball, so that a table whose vertices all lie in the goal divides nothing by 0.
  if (lookup_ == nullptr) d_min_scale_ = std::max<double>(lookup->table().max_cost(), lookup->r_ball());
  lookup_ = std::move(lookup);
  if (experiment_.environment.start == EnvironmentConfig::Start::kCostToGo) {
    cost_starts_ = std::make_shared<const CostStarts>(*lookup_);
  }
}

Pose Scene::TrainingStart(int vehicle, int episode) const {
  RandomStream random(experiment_.seed, RandomPurpose::kStart, static_cast<uint32_t>(vehicle),
                      static_cast<uint32_t>(episode));
  switch (experiment_.environment.start) {
    case EnvironmentConfig::Start::kUniform:
      break;
    case EnvironmentConfig::Start::kStartRegion:
      return DrawStartIn(random, world().start);
    case EnvironmentConfig::Start::kCostToGo:
      CAIRN_CHECK(cost_starts_ != nullptr, "a start by cost-to-go needs a cost table");
      if (!cost_starts_->empty()) return DrawStart(random, world().bounds, [&] { return cost_starts_->Draw(random); });
  }
  return DrawStartIn(random, world().start_space);
}

Pose Scene::EvaluationStart(StartSet set, int index) const {
  CAIRN_CHECK(set != StartSet::kTraining);
  RandomStream random(experiment_.world.seed, StartPurpose(set), static_cast<uint32_t>(index));
  return DrawStartIn(random, world().start_space);
}

Pose Scene::DrawStartIn(RandomStream& random, const Box& region) const {
  return DrawStart(random, region, [&] {
    const double x = random.Uniform(region.min.x(), region.max.x());
    const double y = random.Uniform(region.min.y(), region.max.y());
    const double z = world().dimension == 3 ? random.Uniform(region.min.z(), region.max.z()) : 0;
    return Vector3d(x, y, z);
  });
}

template <typename DrawPoint>
Pose Scene::DrawStart(RandomStream& random, const Box& region, const DrawPoint& draw_point) const {
  const double clearance = experiment_.vehicle.circumscribed_radius() * (1 + kStartMargin);
  for (int draw = 0; draw < kMaxDraws; ++draw) {
    const Vector3d p = draw_point();
    if (world().Contains(world().goal, p) || field().Distance(p) < clearance || !site_->reachability.Reaches(p))
      continue;
    const double yaw = experiment_.vehicle.turns() ? random.Uniform(-std::numbers::pi, std::numbers::pi) : 0;
    return {p.x(), p.y(), yaw, p.z()};
  }
  ThrowUsageError(
      "vehicle: no free start for its circumscribed radius of {:.4g} m among {} draws in x {}..{} m, y {}..{} m",
      experiment_.vehicle.circumscribed_radius(), kMaxDraws, region.min.x(), region.max.x(), region.min.y(),
      region.max.y());
}

}  // namespace cairn::actors
