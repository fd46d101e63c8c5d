#include "common/world/world_variants.h"

#include <gtest/gtest.h>

#include "common/core/check.h"
#include "common/core/random.h"
#include "common/world/distance_field.h"
#include "common/world/reachability.h"
#include "common/world/signed_distance.h"

namespace cairn {
namespace {

constexpr double kCarRadius = 0.03, kQuadrotorRadius = 0.054;

WorldConfig Cube(uint64_t seed = 1) {
  WorldConfig config;
  config.kind = WorldConfig::Kind::kCubeMaze;
  config.seed = seed;
  return config;
}

size_t Added(const World& world, const WorldConfig& config) {
  return world.boxes.size() - MakeWorld(config).boxes.size();
}

// Share of the points that reach the goal in `before` and are free in `after` from which it can be reached in `after`.
double ShareLeft(const World& before, const World& after, double radius) {
  const DistanceField old_field(before, 0.01), field(after, 0.01);
  const Reachability old_reach(before, old_field, radius), reach(after, field, radius);
  RandomStream random(5, RandomPurpose::kTest);
  int points = 0, reached = 0;
  while (points < 2000) {
    Vector3d p = Vector3d::Zero();
    for (int k = 0; k < before.dimension; ++k) {
      p[k] = random.Uniform(before.start_space.min[k], before.start_space.max[k]);
    }
    if (old_field.Distance(p) < radius || !old_reach.Reaches(p) || field.Distance(p) < radius) continue;
    ++points;
    reached += reach.Reaches(p);
  }
  return static_cast<double>(reached) / points;
}

TEST(WorldVariantsTest, AreTheSameWhenNothingIsClosedOrAdded) {
  const WorldVariants variants = MakeWorldVariants(Cube(), kQuadrotorRadius);
  EXPECT_TRUE(variants.same);
  EXPECT_EQ(Added(variants.known, Cube()) + Added(variants.training, Cube()) + Added(variants.evaluation, Cube()), 0u);
}

// The middle of a door is free before and wall after; who meets it and who knows is said by the config.
TEST(WorldVariantsTest, ListedDoorsAreClosedForThoseWhoMeetThem) {
  WorldConfig config = Cube();
  config.blocked_doors = {2, 7};
  const World open = MakeWorld(config);
  const WorldVariants unknown = MakeWorldVariants(config, kQuadrotorRadius);
  for (const int door : config.blocked_doors) {
    const Vector3d middle = open.doors[static_cast<size_t>(door)].center();
    EXPECT_GT(SignedDistance(open, middle), 0.07);
    EXPECT_GT(SignedDistance(unknown.known, middle), 0.07);
    EXPECT_LT(SignedDistance(unknown.training, middle), 0);
    EXPECT_LT(SignedDistance(unknown.evaluation, middle), 0);
  }
  config.blocked_known = true;
  EXPECT_EQ(Added(MakeWorldVariants(config, kQuadrotorRadius).known, config), 2u);
  config.blocked_when = WorldConfig::BlockedWhen::kEvaluation;
  const WorldVariants late = MakeWorldVariants(config, kQuadrotorRadius);
  EXPECT_EQ(Added(late.training, config), 0u);
  EXPECT_EQ(Added(late.evaluation, config), 2u);
}

TEST(WorldVariantsTest, RandomDoorsLieOnOneFloorAndLeaveHalfOfTheStarts) {
  for (uint64_t seed = 21; seed < 25; ++seed) {
    WorldConfig config = Cube(seed);
    config.random_blocked_doors = 3;
    const World open = MakeWorld(config);
    const WorldVariants variants = MakeWorldVariants(config, kQuadrotorRadius);
    ASSERT_EQ(Added(variants.training, config), 3u);
    const double height = variants.training.boxes.back().center().z();
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(variants.training.boxes[open.boxes.size() + i].center().z(), height, 1e-9);
    }
    EXPECT_GE(ShareLeft(open, variants.training, kQuadrotorRadius), 0.45);
  }
}

TEST(WorldVariantsTest, UnseenObstaclesStandInEvaluationOnlyAndLeaveAPassage) {
  for (uint64_t seed = 1; seed < 4; ++seed) {
    WorldConfig config;
    config.seed = seed;
    config.unseen_obstacles = 8;
    const WorldVariants variants = MakeWorldVariants(config, kCarRadius);
    EXPECT_EQ(Added(variants.known, config) + Added(variants.training, config), 0u);
    EXPECT_EQ(Added(variants.evaluation, config), 8u);
    EXPECT_FALSE(variants.same);
    EXPECT_GE(ShareLeft(variants.training, variants.evaluation, kCarRadius), 0.99);
  }
}

TEST(WorldVariantsTest, DependOnTheWorldsSeedAlone) {
  WorldConfig config = Cube(3);
  config.random_blocked_doors = 2;
  config.unseen_obstacles = 3;
  config.unseen_obstacle_size = 0.04;
  const WorldVariants a = MakeWorldVariants(config, kQuadrotorRadius), b = MakeWorldVariants(config, kQuadrotorRadius);
  ASSERT_EQ(a.evaluation.boxes.size(), b.evaluation.boxes.size());
  for (size_t i = 0; i < a.evaluation.boxes.size(); ++i)
    EXPECT_EQ(a.evaluation.boxes[i].min, b.evaluation.boxes[i].min);
}

void ExpectRefused(const WorldConfig& config, const std::string& words) {
  try {
    MakeWorldVariants(config, kQuadrotorRadius);
    FAIL() << words;
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(WorldVariantsTest, AVehicleFitsTheDimensionOfItsWorld) {
  Experiment experiment;
  EXPECT_NO_THROW(MakeWorldVariants(experiment));
  experiment.vehicle.kind = VehicleConfig::Kind::kQuadrotor;
  EXPECT_THROW(MakeWorldVariants(experiment), UsageError);
  experiment.world = Cube();
  EXPECT_NO_THROW(MakeWorldVariants(experiment));
  experiment.vehicle.kind = VehicleConfig::Kind::kHolonomic;
  EXPECT_THROW(MakeWorldVariants(experiment), UsageError);
}

TEST(WorldVariantsTest, RefusesWhatCannotBe) {
  WorldConfig config = Cube();
  config.blocked_doors = {4711};
  ExpectRefused(config, "world.blocked_doors: 4711");
  config = Cube();
  config.random_blocked_doors = 900;
  ExpectRefused(config, "world.random_blocked_doors = 900: no floor");
}

}  // namespace
}  // namespace cairn
