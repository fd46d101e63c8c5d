#include "planner/roadmap_service.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "common/bus/goal_table_client.h"
#include "common/bus/table_client.h"
#include "common/core/check.h"
#include "common/core/random.h"
#include "common/roadmap/roadmap_blob.h"

namespace cairn::planner {
namespace {

using std::chrono::milliseconds;

constexpr uint64_t kHash = 0x77;

Experiment MakeExperiment() {
  Experiment experiment;
  experiment.goals = Goals::kAny;
  experiment.world.cells = 5;
  experiment.world.training_worlds = 2;
  experiment.planner.table_cache_mb = 1;
  return experiment;
}

BusConfig Config(int block) {
  BusConfig config;
  config.base_port = 21400 + 10 * block;
  config.run_id = 42;
  config.session = RandomId();
  return config;
}

// A service that runs until the end of the test.
class Planner {
 public:
  Planner(int block, const Experiment& experiment)
      : bus_(Config(block)),
        service_(&bus_, kHash, experiment),
        thread_([this](const std::stop_token& stop) { service_.Run([&stop] { return stop.stop_requested(); }); }) {}

 private:
  Bus bus_;
  RoadmapService service_;
  std::jthread thread_;
};

template <typename Done>
bool Until(Bus* bus, GoalTableClient* client, Done done) {
  for (const TimePoint end = Clock::now() + std::chrono::seconds(20); Clock::now() < end;) {
    if (done()) return true;
    bus->Poll(milliseconds(5));
    client->Poll(Clock::now());
  }
  return false;
}

std::vector<WorldGoal> DrawGoals(const World& world, uint64_t seed, int count) {
  RandomStream random(seed, RandomPurpose::kTest);
  std::vector<WorldGoal> goals;
  for (int i = 0; i < count; ++i) {
    const Vector3d p(random.Uniform(0, world.bounds.max.x()), random.Uniform(0, world.bounds.max.y()), 0);
    const Vector3d half(0.06, 0.06, 0);
    goals.emplace_back(seed, Box{p - half, p + half});
  }
  return goals;
}

TEST(RoadmapServiceTest, ServesTheTableOfAnyGoalInAnyWorld) {
  const Experiment experiment = MakeExperiment();
  WorldPlanner reference(experiment);
  Planner planner(0, experiment);
  Bus bus(Config(0));
  std::vector<std::pair<WorldGoal, uint64_t>> come;
  GoalTableClient client(&bus, kHash, [&](const WorldGoal& goal, const Roadmap& positions, const CostTable& table) {
    EXPECT_EQ(positions.num_vertices(), static_cast<int>(table.cost.size()));
    come.emplace_back(goal, table.Hash());
  });
  bus.CheckPlanes();
  std::vector<WorldGoal> goals;
  for (const uint64_t seed : {1, 2}) {
    for (const WorldGoal& goal : DrawGoals(reference.Site(seed).world, seed, 30)) goals.push_back(goal);
  }
  for (const WorldGoal& goal : goals) client.Want(goal);
  for (const WorldGoal& goal : goals) client.Want(goal);  // on its way: nothing more comes of it
  ASSERT_TRUE(Until(&bus, &client, [&] { return client.idle(); }));
  ASSERT_EQ(come.size(), goals.size());
  for (const auto& [goal, hash] : come) {
    EXPECT_EQ(hash, reference.Table(goal.world_seed, goal.box()).Hash()) << goal.min[0];
  }
  // The cache has forgotten the first ones; they are made anew.
  client.Want(goals.front());
  ASSERT_TRUE(Until(&bus, &client, [&] { return client.idle(); }));
  EXPECT_EQ(come.back().second, come.front().second);
}

TEST(RoadmapServiceTest, SaysThatAGoalHasNoTable) {
  Planner planner(1, MakeExperiment());
  Bus bus(Config(1));
  std::vector<size_t> sizes;
  GoalTableClient client(&bus, kHash, [&](const WorldGoal&, const Roadmap&, const CostTable& table) {
    sizes.push_back(table.cost.size());
  });
  bus.CheckPlanes();
  client.Want({1, {Vector3d(9, 9, 0), Vector3d(9.1, 9.1, 0)}});       // far outside
  client.Want({77, {Vector3d(0.1, 0.1, 0), Vector3d(0.2, 0.2, 0)}});  // a world that the experiment does not have
  ASSERT_TRUE(Until(&bus, &client, [&] { return client.idle(); }));
  EXPECT_EQ(sizes, (std::vector<size_t>{0, 0}));
}

TEST(RoadmapServiceTest, StillServesTheExperimentsOwnTable) {
  const Experiment experiment = MakeExperiment();
  WorldPlanner reference(experiment);
  const CostTable own = reference.Table(experiment.world.seed, reference.Home().world.goal);
  Planner planner(2, experiment);
  Bus bus(Config(2));
  TableClient client(&bus, kHash);
  bus.CheckPlanes();
  client.RequestInfo();
  std::optional<TableClient::Tables> tables;
  for (const TimePoint end = Clock::now() + std::chrono::seconds(20); !tables && Clock::now() < end;) {
    bus.Poll(milliseconds(5));
    client.Poll(Clock::now());
    if (client.info()) client.Want(client.info()->roadmap_hash, client.info()->table_hash);
    tables = client.Take();
  }
  ASSERT_TRUE(tables);
  EXPECT_EQ(tables->table.cost, own.cost);
  EXPECT_EQ(client.info()->table_hash, own.Hash());
}

TEST(WorldPlannerTest, AnyGoalsTableMatchesTheOneOfItsOwnWorld) {
  const Experiment experiment = MakeExperiment();
  WorldPlanner planner(experiment);
  const PlannedSite& home = planner.Home();
  EXPECT_EQ(planner.Table(1, home.world.goal).Hash(),
            ComputeCostTable(home.built.roadmap, home.world, home.world.goal).Hash());
  EXPECT_NE(planner.Site(2).built.roadmap.Hash(), home.built.roadmap.Hash());
  EXPECT_FALSE(planner.BuildAhead()) << "both are built";
  EXPECT_THROW(planner.Table(3, home.world.goal), UsageError);
}

std::vector<float> Flat(const std::vector<Vector3d>& points) {
  std::vector<float> flat;
  for (const Vector3d& p : points) {
    for (int k = 0; k < 3; ++k) flat.push_back(static_cast<float>(p[k]));
  }
  return flat;
}

// Marks across a door cost the way through it; what they do not touch keeps its cost.
TEST(WorldPlannerTest, MarksCloseADoor) {
  const Experiment experiment = MakeExperiment();
  WorldPlanner planner(experiment);
  const World& world = planner.Home().world;
  const CostTable open = planner.Table(1, world.goal);
  EXPECT_EQ(planner.Table(1, world.goal, {}).Hash(), open.Hash());
  int closing = 0;
  for (const Box& door : world.doors) {
    const Vector3d half = 0.5 * door.size(), middle = door.center();
    const CostTable shut = planner.Table(1, world.goal, Flat({middle - 0.5 * half, middle, middle + 0.5 * half}));
    EXPECT_EQ(shut.roadmap_hash, open.roadmap_hash);
    EXPECT_EQ(shut.marks.size(), 9u);
    EXPECT_NEAR(shut.mark_reach, experiment.planner.radius + experiment.planner.repair_mark_radius, 1e-7);
    int dearer = 0;
    for (size_t v = 0; v < open.cost.size(); ++v) {
      EXPECT_GE(shut.cost[v], open.cost[v]);
      dearer += shut.cost[v] > open.cost[v] + 0.3f;
    }
    closing += dearer > 0;
  }
  EXPECT_GT(closing, static_cast<int>(world.doors.size()) / 2) << "a maze has few ways";
}

// A point in free space is served by the vertices around it.
TEST(WorldPlannerTest, APointIsAGoalToo) {
  const Experiment experiment = MakeExperiment();
  WorldPlanner planner(experiment);
  const Roadmap& roadmap = planner.Home().built.roadmap;
  const Vector3d p = roadmap.position(roadmap.num_vertices() / 2) + Vector3d(0.003, -0.002, 0);
  const CostTable table = planner.Table(1, {p, p});
  EXPECT_EQ(table.goal.min, p);
  int at_goal = 0;
  for (int v = 0; v < roadmap.num_vertices(); ++v) {
    if (table.cost[v] != 0) continue;
    ++at_goal;
    EXPECT_LE((roadmap.position(v) - p).cwiseAbs().maxCoeff(), experiment.planner.r_ball() + 1e-6);
  }
  EXPECT_GE(at_goal, 1);
}

}  // namespace
}  // namespace cairn::planner
