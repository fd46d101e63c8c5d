#include "actors/goal_tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/core/check.h"
#include "common/core/random.h"

namespace cairn::actors {
namespace {

BusConfig Config() {
  BusConfig config;
  config.base_port = 21900;
  config.run_id = 42;
  config.session = RandomId();
  return config;
}

// A process that a UsageError ends is not started again.
TEST(GoalTablesTest, AGoalWithoutATableIsAUsageErrorThatSaysWhatHelps) {
  constexpr uint64_t kHash = 0x77;
  Experiment experiment;
  experiment.world.goal_tolerance = 0.001;
  Bus planner(Config()), actor(Config());
  GoalTables tables(&actor, experiment, kHash);
  const WorldGoal goal(3, {Vector3d(0.1, 0.2, 0), Vector3d(0.102, 0.202, 0)});
  EXPECT_EQ(tables.Find(goal), nullptr);
  TableInfo none;
  none.experiment_hash = kHash;
  none.goal = goal;
  for (const TimePoint end = Clock::now() + std::chrono::seconds(20); tables.waiting() && Clock::now() < end;) {
    planner.Publish(Plane::kTables, kTableInfoChannel, none);
    actor.Poll(std::chrono::milliseconds(5));
    tables.Poll(Clock::now());
  }
  try {
    tables.Find(goal);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("world.goal_tolerance = 0.001 m"),
                                             testing::HasSubstr("(0.1, 0.2, 0) to (0.102, 0.202, 0) m of world 3"),
                                             testing::HasSubstr("planner.coverage")));
  }
}

}  // namespace
}  // namespace cairn::actors
