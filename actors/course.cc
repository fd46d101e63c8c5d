#include "actors/course.h"

#include "common/core/check.h"

namespace cairn::actors {
namespace {

constexpr size_t kMaxWorlds = 256;  // of a few MB each; more are made anew when their turn comes
constexpr size_t kMaxGoals = 65536;

}  // namespace

Course::Course(std::shared_ptr<const Scene> home, FindTable find_table)
    : home_(std::move(home)), find_table_(std::move(find_table)), worlds_(kMaxWorlds), goals_(kMaxGoals) {
  CAIRN_CHECK(home_->experiment().goals == Goals::kWorld || find_table_ != nullptr);
}

Course::Place Course::TrainingPlace(int vehicle, int episode) const {
  const Experiment& experiment = home_->experiment();
  RandomStream random(experiment.seed, RandomPurpose::kGoal, static_cast<uint32_t>(vehicle),
                      static_cast<uint32_t>(episode));
  Place place;
  place.world_seed = experiment.world.seed + random.Below(static_cast<uint32_t>(experiment.world.training_worlds));
  place.goal = static_cast<int>(random.Below(static_cast<uint32_t>(experiment.world.goals_per_world)));
  return place;
}

// The worlds in turn, each start with a goal of its own.
Course::Place Course::EvaluationPlace(StartSet set, int start) const {
  const WorldConfig& world = home_->experiment().world;
  const int unseen = world.unseen_worlds;
  const uint64_t first = world.seed + static_cast<uint64_t>(unseen > 0 ? world.training_worlds : 0);
  return {first + static_cast<uint64_t>(start % (unseen > 0 ? unseen : world.training_worlds)), set, start};
}

// Of evaluation the variant with what stands there only then.
std::shared_ptr<const Scene> Course::World(uint64_t seed, StartSet set) {
  std::shared_ptr<const Scene> world = home_;
  if (seed != home_->experiment().world.seed) {
    if (const auto* known = worlds_.Find(seed)) {
      world = *known;
    } else {
      Experiment experiment = home_->experiment();
      experiment.world.seed = seed;
      world = *worlds_.Insert(seed, std::make_shared<const Scene>(std::move(experiment)));
    }
  }
  return set == StartSet::kTraining ? world : Scene::ForEvaluation(world);
}

const Box& Course::Goal(const Place& place) {
  const GoalName name{place.world_seed, static_cast<uint64_t>(place.set) << 32 | static_cast<uint32_t>(place.goal)};
  if (const Box* known = goals_.Find(name)) return *known;
  return *goals_.Insert(name, World(place.world_seed, place.set)->DrawGoal(place.set, place.goal));
}

std::optional<Scene> Course::Find(const Place& place) {
  const Box goal = Goal(place);
  std::shared_ptr<const RoadmapLookup> table = find_table_({place.world_seed, goal});
  if (table == nullptr) return std::nullopt;
  return World(place.world_seed, place.set)->WithGoal(goal, std::move(table), home_->d_min_scale());
}

std::optional<Scene> Course::Training(int vehicle, int episode) {
  if (home_->experiment().goals == Goals::kWorld) return *home_;
  return Find(TrainingPlace(vehicle, episode));
}

std::optional<Scene> Course::Evaluation(StartSet set, int start) {
  if (home_->experiment().goals == Goals::kWorld) return *Scene::ForEvaluation(home_);
  return Find(EvaluationPlace(set, start));
}

std::shared_ptr<const RoadmapLookup> Course::MendedTable(const Scene& scene, std::vector<float> marks) {
  const Experiment& experiment = scene.experiment();
  if (marks.empty() && experiment.goals == Goals::kWorld) return home_->shared_lookup();
  CAIRN_CHECK(find_table_ != nullptr, "repair needs tables");
  return find_table_({experiment.world.seed, scene.goal(), std::move(marks)});
}

void Course::PrefetchTraining(int vehicle, int episode) {
  if (home_->experiment().goals == Goals::kWorld) return;
  const Place place = TrainingPlace(vehicle, episode);
  find_table_({place.world_seed, Goal(place)});
}

void Course::PrefetchEvaluation(StartSet set, int start) {
  if (home_->experiment().goals == Goals::kWorld) return;
  const Place place = EvaluationPlace(set, start);
  find_table_({place.world_seed, Goal(place)});
}

}  // namespace cairn::actors
