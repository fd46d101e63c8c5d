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
constexpr int kDistantDraws = 1000;  // of them, that must be far from the goal
constexpr int kGoalDraws = 32;       // free places, the roomiest of which is a goal if none has all the room wanted

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
  const double reach =
      1.01 * footprint_.circumscribed_radius() * std::max(1.0, experiment_.environment.largest_footprint());
  const auto make = [&](const World& world) { return std::make_shared<const Site>(world, experiment_, reach); };
  site_ = make(variants.training);
  goal_ = site_->world.goal;
  known_site_ = variants.same ? site_ : make(variants.known);
  evaluation_site_ = variants.same ? site_ : make(variants.evaluation);
}

Scene::Site::Site(const World& w, const Experiment& experiment, double reach)
    : world(w), field(world, experiment.world.field_resolution), reachability(world, field, experiment.planner.radius) {
  if (world.dimension == 2) obstacles.emplace(world, reach);
  if (world.dimension == 3) space_obstacles.emplace(world, reach);
  // Elsewhere doors that are shut may cut the region off: they leave the goal to half of all starts.
  if (experiment.environment.start == EnvironmentConfig::Start::kStartRegion) reachability.CheckStart();
}

double Scene::Site::CastRay(const Vector3d& p, const Vector3d& direction, double max_range) const {
  return world.dimension == 3 ? space_obstacles->CastRay(p, direction, max_range)
                              : obstacles->CastRay(p.x(), p.y(), direction.x(), direction.y(), max_range);
}

bool Scene::TouchesKnown(const Motion& motion) const {
  Footprint swollen = footprint_;
  for (double* length : {&swollen.half_length, &swollen.half_width, &swollen.radius}) *length *= 1.001;
  const Vector3d p(motion.x, motion.y, motion.z);
  return world().dimension == 3 ? known_site_->space_obstacles->Overlaps(p, swollen.radius)
                                : known_site_->obstacles->Overlaps(p.x(), p.y(), motion.yaw, swollen);
}

std::shared_ptr<const Scene> Scene::ForEvaluation(const std::shared_ptr<const Scene>& scene) {
  if (scene->site_ == scene->evaluation_site_) return scene;
  const auto evaluation = std::make_shared<Scene>(*scene);
  evaluation->site_ = scene->evaluation_site_;
  return evaluation;
}

void Scene::SetTable(std::shared_ptr<const RoadmapLookup> lookup) {
  CAIRN_CHECK(lookup != nullptr);
  if (lookup_ == nullptr) d_min_scale_ = ScaleOf(*lookup);
  lookup_ = std::move(lookup);
  if (experiment_.environment.start == EnvironmentConfig::Start::kCostToGo) {
    cost_starts_ = std::make_shared<const CostStarts>(*lookup_);
  }
}

// At least r_ball, so that a table whose vertices all lie in the goal divides nothing by 0.
double Scene::ScaleOf(const RoadmapLookup& lookup) {
  return std::max<double>(lookup.table().max_cost(), lookup.r_ball());
}

Box Scene::DrawGoal(StartSet set, int index) const {
  RandomStream random(experiment_.world.seed, RandomPurpose::kGoal, static_cast<uint32_t>(index),
                      static_cast<uint32_t>(set));
  const double clearance = experiment_.vehicle.circumscribed_radius() * (1 + kStartMargin);
  const Box& space = world().bounds;
  Box roomiest;
  double most_room = 0;
  int found = 0;
  for (int draw = 0; draw < kMaxDraws && found < kGoalDraws; ++draw) {
    Vector3d p = Vector3d::Zero();
    for (int k = 0; k < world().dimension; ++k) p[k] = random.Uniform(space.min[k], space.max[k]);
    if (field().Distance(p) < clearance || !site_->reachability.Reaches(p)) continue;
    ++found;
    const Box region = RegionAround(world(), p, experiment_.world.goal_tolerance);
    double room = region.size().x();
    for (int k = 1; k < world().dimension; ++k) room = std::min(room, region.size()[k]);
    if (room > most_room) roomiest = region;
    most_room = std::max(most_room, room);
    if (room >= 2 * experiment_.world.goal_tolerance * (1 - 1e-9)) break;
  }
  if (found == 0) ThrowNoRoom("goal", clearance, space);
  return roomiest;
}

Scene Scene::WithGoal(const Box& goal, std::shared_ptr<const RoadmapLookup> lookup, double scale) const {
  Scene scene = *this;
  scene.goal_ = goal;
  scene.SetTable(std::move(lookup));
  scene.d_min_scale_ = scale;
  return scene;
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
  return DrawStartIn(random, StartSpace());
}

Pose Scene::EvaluationStart(StartSet set, int index) const {
  CAIRN_CHECK(set != StartSet::kTraining);
  RandomStream random(experiment_.world.seed, StartPurpose(set), static_cast<uint32_t>(index));
  return DrawStartIn(random, StartSpace());
}

// Where goals lie anywhere, starts do.
const Box& Scene::StartSpace() const { return experiment_.goals == Goals::kAny ? world().bounds : world().start_space; }

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
  const double clearance = experiment_.vehicle.circumscribed_radius() *
                           std::max(1.0, experiment_.environment.largest_footprint()) * (1 + kStartMargin);
  for (int draw = 0; draw < kMaxDraws; ++draw) {
    const Vector3d p = draw_point();
    if (world().Contains(goal_, p) || field().Distance(p) < clearance || !site_->reachability.Reaches(p)) continue;
    if (TooNear(p, draw)) continue;
    const double yaw = experiment_.vehicle.turns() ? random.Uniform(-std::numbers::pi, std::numbers::pi) : 0;
    return {p.x(), p.y(), yaw, p.z()};
  }
  ThrowNoRoom("start", clearance, region);
}

// Any goal: a start from which the roadmap does not lead there is none, and one beside it teaches nothing.
bool Scene::TooNear(const Vector3d& p, int draw) const {
  if (experiment_.goals == Goals::kWorld) return false;
  const float cost = lookup_->CostToGo(p);
  return !std::isfinite(cost) || (draw < kDistantDraws && cost < experiment_.world.goal_distance);
}

void Scene::ThrowNoRoom(const char* what, double clearance, const Box& region) const {
  ThrowUsageError("vehicle: no free {} {:.4g} m from obstacles among {} draws in x {}..{} m, y {}..{} m", what,
                  clearance, kMaxDraws, region.min.x(), region.max.x(), region.min.y(), region.max.y());
}

}  // namespace cairn::actors
