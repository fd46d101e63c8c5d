#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "actors/scene.h"
#include "common/bus/lru_map.h"
#include "common/roadmap/world_goal.h"

namespace cairn::actors {

/// Which world and goal each episode has, and the scene that follows. With goals = WORLD always the home scene; with
/// ANY both are drawn from the episode's own key, so that they do not depend on who runs it, and their cost tables come
/// from the planner. One thread.
class Course {
 public:
  /// The table of a goal; nullptr while it is not here. Asks for it, if need be, each time.
  using FindTable = std::function<std::shared_ptr<const RoadmapLookup>(const WorldGoal&)>;

  /// `home` has the experiment's own goal's table when the first episode begins: it gives D_min's scale everywhere.
  /// `find_table` is asked with goals = ANY and for repair only.
  explicit Course(std::shared_ptr<const Scene> home, FindTable find_table = {});

  /// The scene of the vehicle's training episode; none while its table is on its way.
  std::optional<Scene> Training(int vehicle, int episode);
  /// The scene of an evaluation start; none while its table is on its way.
  std::optional<Scene> Evaluation(StartSet set, int start);

  /// The table of a scene of this course around these marks; nullptr while it is on its way. Without marks its own.
  std::shared_ptr<const RoadmapLookup> MendedTable(const Scene& scene, std::vector<float> marks);

  /// Asks for what these will need.
  void PrefetchTraining(int vehicle, int episode);
  void PrefetchEvaluation(StartSet set, int start);

  const Scene& home() const { return *home_; }

 private:
  struct Place {
    uint64_t world_seed = 0;
    StartSet set = StartSet::kTraining;
    int goal = 0;  ///< index within the set
  };
  Place TrainingPlace(int vehicle, int episode) const;
  Place EvaluationPlace(StartSet set, int start) const;
  std::shared_ptr<const Scene> World(uint64_t seed, StartSet set);
  const Box& Goal(const Place& place);
  std::optional<Scene> Find(const Place& place);

  using GoalName = std::array<uint64_t, 2>;  // world; set and index
  struct GoalNameHash {
    size_t operator()(const GoalName& name) const { return ContentHash(name.data(), sizeof(name)); }
  };

  std::shared_ptr<const Scene> home_;
  FindTable find_table_;
  LruMap<uint64_t, std::shared_ptr<const Scene>> worlds_;  // by seed
  LruMap<GoalName, Box, GoalNameHash> goals_;
};

}  // namespace cairn::actors
