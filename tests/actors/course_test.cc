#include "actors/course.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "actors/evaluation.h"
#include "actors/rollout.h"
#include "common/core/check.h"
#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

// Small mazes, so that their tables take little time.
Experiment AnyGoalExperiment() {
  Experiment experiment = NoisyMazeExperiment();
  experiment.goals = Goals::kAny;
  experiment.world.cells = 5;
  experiment.world.training_worlds = 3;
  experiment.world.unseen_worlds = 2;
  experiment.world.goals_per_world = 4;
  experiment.environment.max_episode_steps = 12;
  experiment.environment.retry_failed_start = 0.5;
  return experiment;
}

// Tables over lattices, each of which comes only when it has been asked for `delay` times.
class SlowTables {
 public:
  SlowTables(const Experiment& experiment, int delay) : experiment_(experiment), delay_(delay) {}

  std::shared_ptr<const RoadmapLookup> operator()(const WorldGoal& goal) {
    Entry& entry = (*entries_)[{static_cast<double>(goal.world_seed), goal.min[0], goal.min[1], goal.max[0]}];
    if (entry.asked++ < delay_) return nullptr;
    if (entry.table == nullptr) {
      WorldConfig config = experiment_.world;
      config.seed = goal.world_seed;
      World world = MakeWorld(config);
      world.goal = goal.box();
      const DistanceField field(world, config.field_resolution);
      entry.table =
          testing::MakeGridLookup(world, field, 0.025, experiment_.planner.radius, experiment_.planner.r_ball());
    }
    return entry.table;
  }

  size_t size() const { return entries_->size(); }

 private:
  struct Entry {
    int asked = 0;
    std::shared_ptr<const RoadmapLookup> table;
  };
  Experiment experiment_;
  int delay_;
  std::shared_ptr<std::map<std::array<double, 4>, Entry>> entries_ =
      std::make_shared<std::map<std::array<double, 4>, Entry>>();  // shared by the copies of this
};

std::shared_ptr<Course> MakeCourse(const Experiment& experiment, const SlowTables& tables) {
  return std::make_shared<Course>(MakeScene(experiment), tables);
}

bool Contains(const Box& outer, const Box& inner) {
  return (outer.min.array() <= inner.min.array() + 1e-12).all() &&
         (outer.max.array() >= inner.max.array() - 1e-12).all();
}

TEST(CourseTest, TrainingMeetsItsWorldsAndGoalsAndEvaluationOthers) {
  const Experiment experiment = AnyGoalExperiment();
  const SlowTables tables(experiment, 0);
  const auto course = MakeCourse(experiment, tables);
  std::set<uint64_t> worlds;
  std::set<double> goals;
  for (int episode = 0; episode < 60; ++episode) {
    const std::optional<Scene> scene = course->Training(2, episode);
    ASSERT_TRUE(scene);
    worlds.insert(scene->experiment().world.seed);
    goals.insert(scene->goal().min.x());
    EXPECT_EQ(scene->lookup().table().goal.min, scene->goal().min);
    EXPECT_EQ(scene->d_min_scale(), course->home().d_min_scale());
  }
  EXPECT_EQ(worlds, (std::set<uint64_t>{1, 2, 3}));
  EXPECT_EQ(goals.size(), 12u) << "four of each world";
  std::set<uint64_t> unseen;
  for (int start = 0; start < 6; ++start) {
    const std::optional<Scene> scene = course->Evaluation(StartSet::kTest, start);
    unseen.insert(scene->experiment().world.seed);
    EXPECT_EQ(goals.count(scene->goal().min.x()), 0u);
    goals.insert(scene->goal().min.x());
  }
  EXPECT_EQ(unseen, (std::set<uint64_t>{4, 5}));
  EXPECT_EQ(goals.size(), 18u) << "each start has its own";
}

TEST(CourseTest, GoalsAreFreeAndStartsFarFromThem) {
  const Experiment experiment = AnyGoalExperiment();
  const SlowTables tables(experiment, 0);
  const auto course = MakeCourse(experiment, tables);
  for (int episode = 0; episode < 40; ++episode) {
    const std::optional<Scene> scene = course->Training(0, episode);
    EXPECT_TRUE(Contains(scene->world().bounds, scene->goal()));
    EXPECT_GE(scene->field().Distance(scene->goal().center()), experiment.vehicle.circumscribed_radius());
    EXPECT_NEAR(scene->goal().size().x(), 2 * experiment.world.goal_tolerance, 1e-9);
    const Pose start = scene->TrainingStart(0, episode);
    EXPECT_GE(scene->lookup().CostToGo(Vector3d(start.x, start.y, 0)), experiment.world.goal_distance);
    const Pose same = course->Training(0, episode)->TrainingStart(0, episode);
    EXPECT_EQ(start.x, same.x);
  }
}

// Whatever each vehicle made, in order.
std::map<int, std::vector<float>> RollOut(const Experiment& experiment, int delay,
                                          const std::vector<int32_t>& vehicles) {
  Rollout rollout(MakeCourse(experiment, SlowTables(experiment, delay)));
  const std::vector<int32_t> none(vehicles.size(), 0);
  rollout.Assign(vehicles, none, std::vector<int64_t>(vehicles.size(), 0));
  int waited = 0;
  for (bool complete = false; !complete;) {
    complete = true;
    std::vector<int> active;
    for (int i = 0; i < rollout.num_vehicles(); ++i) {
      if (rollout.transitions(i) >= 60) continue;
      complete = false;
      if (rollout.Ready(i)) active.push_back(i);
      waited += active.empty() || active.back() != i;
    }
    if (!active.empty()) rollout.Step(active, {nullptr, true, 1, 2});
  }
  EXPECT_EQ(waited > 0, delay > 1);
  std::map<int, std::vector<float>> made;
  for (const Segment& s : rollout.TakeSegments()) {
    std::vector<float>& numbers = made[s.vehicle];
    numbers.push_back(static_cast<float>(s.episode));
    numbers.push_back(static_cast<float>(s.table_hash % 1000003));
    numbers.insert(numbers.end(), s.observations.begin(), s.observations.end());
    numbers.insert(numbers.end(), s.rewards.begin(), s.rewards.end());
  }
  return made;
}

TEST(CourseTest, WhatVehiclesDoDoesNotDependOnWhenTablesComeNorOnTheirCompany) {
  const Experiment experiment = AnyGoalExperiment();
  const auto at_once = RollOut(experiment, 0, {0, 1, 2});
  EXPECT_EQ(at_once, RollOut(experiment, 7, {0, 1, 2}));
  EXPECT_EQ(at_once.at(1), RollOut(experiment, 5, {1}).at(1));
}

TEST(CourseTest, ASavedVehicleGoesOnInItsWorld) {
  const Experiment experiment = AnyGoalExperiment();
  const auto course = MakeCourse(experiment, SlowTables(experiment, 0));
  Rollout first(course), second(course), late(MakeCourse(experiment, SlowTables(experiment, 3)));
  const RolloutContext context{nullptr, true, 1, 2};
  first.Assign({3}, {0}, {0});
  for (int i = 0; i < 17; ++i) first.Step({0}, context);
  first.TakeSegments();
  const Bytes state = first.SaveVehicle(0);
  second.Assign({3}, {0}, {17}, {state});
  EXPECT_EQ(second.SaveVehicle(0), state);
  late.Assign({3}, {0}, {17}, {state});
  EXPECT_EQ(late.SaveVehicle(0), state) << "its table is not here yet";
  while (!late.Ready(0)) {
  }
  for (int i = 0; i < 20; ++i) {
    first.Step({0}, context);
    second.Step({0}, context);
    while (!late.Ready(0)) {
    }
    late.Step({0}, context);
  }
  const std::vector<Segment> a = first.TakeSegments(), b = second.TakeSegments(), c = late.TakeSegments();
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a.size(), c.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].observations, b[i].observations);
    EXPECT_EQ(a[i].observations, c[i].observations);
    EXPECT_EQ(a[i].table_hash, b[i].table_hash);
  }
}

// The next episode's table is on its way and the state is taken: whoever goes on begins that episode.
TEST(CourseTest, AVehicleThatWaitsIsSavedWithoutItsEpisode) {
  const Experiment experiment = AnyGoalExperiment();
  Rollout waiting(MakeCourse(experiment, SlowTables(experiment, 1000000)));
  waiting.Assign({1}, {5}, {40});
  EXPECT_FALSE(waiting.Ready(0));
  const Bytes state = waiting.SaveVehicle(0);
  Rollout begun(MakeCourse(experiment, SlowTables(experiment, 0))),
      other(MakeCourse(experiment, SlowTables(experiment, 0)));
  begun.Assign({1}, {0}, {40}, {state});
  other.Assign({1}, {5}, {40});
  EXPECT_EQ(begun.SaveVehicle(0), other.SaveVehicle(0));
}

class Ahead final : public Controller {
 public:
  void Act(std::span<const Environment* const> environments, float* actions) override {
    for (size_t i = 0; i < environments.size(); ++i) {
      *actions++ = 0;
      *actions++ = static_cast<float>(std::sin(environments[i]->pose().yaw));
    }
  }
};

TEST(CourseTest, EvaluationsDoNotDependOnWhenTablesCome) {
  Experiment experiment = AnyGoalExperiment();
  experiment.evaluation.max_steps = 20;
  Ahead ahead;
  std::vector<std::vector<EpisodeResult>> results;
  for (const int delay : {0, 4}) {
    EvaluationBatch batch(MakeCourse(experiment, SlowTables(experiment, delay)), StartSet::kTest, AllStarts(12),
                          {.max_batch = 5});
    int waited = 0;
    while (!batch.done()) waited += !batch.Step(ahead);
    EXPECT_EQ(waited > 0, delay > 0);
    results.push_back(batch.results());
  }
  for (size_t i = 0; i < results[0].size(); ++i) {
    EXPECT_EQ(results[0][i].steps, results[1][i].steps);
    EXPECT_EQ(results[0][i].path_length, results[1][i].path_length);
    EXPECT_EQ(results[0][i].shortest_length, results[1][i].shortest_length);
  }
}

}  // namespace
}  // namespace cairn::actors
