#include "actors/surprise_finder.h"

#include <gtest/gtest.h>

#include "common/world/world_variants.h"
#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

// A maze in which door 3 is shut, and a vehicle in front of it.
class SurpriseFinderTest : public ::testing::Test {
 protected:
  static Experiment MakeExperiment(bool known) {
    Experiment experiment;
    experiment.world.cells = 5;
    experiment.world.blocked_doors = {3};
    experiment.world.blocked_known = known;
    experiment.planner.repair = PlannerConfig::Repair::kRays;
    return experiment;
  }

  // Half a corridor before the middle of the door, heading for it.
  static Motion BeforeTheDoor(const Scene& scene) {
    const Box door = scene.world().doors[3];
    const Vector3d p = door.center();
    Motion motion{};
    const bool across_x = door.size().x() < door.size().y();
    motion.x = p.x() - (across_x ? 0.08 : 0);
    motion.y = p.y() - (across_x ? 0 : 0.08);
    motion.yaw = across_x ? 0 : M_PI / 2;
    return motion;
  }

  static Findings Look(const Scene& scene, const Motion& motion) {
    Findings findings;
    RangeFinder ranges(scene);
    SurpriseFinder(scene).LookAround(motion, ranges, &findings);
    return findings;
  }
};

TEST_F(SurpriseFinderTest, RaysFindAShutDoorAndNothingElse) {
  const auto scene = MakeScene(MakeExperiment(false));
  const Findings findings = Look(*scene, BeforeTheDoor(*scene));
  ASSERT_FALSE(findings.found.empty());
  EXPECT_TRUE(findings.freed.empty());
  for (const Vector3d& p : findings.found) EXPECT_TRUE(scene->world().Contains(scene->world().doors[3], p)) << p;
}

TEST_F(SurpriseFinderTest, KnownDoorsAreNoSurprise) {
  const auto scene = MakeScene(MakeExperiment(true));
  const Findings findings = Look(*scene, BeforeTheDoor(*scene));
  EXPECT_TRUE(findings.found.empty());
  EXPECT_TRUE(findings.freed.empty());
}

TEST_F(SurpriseFinderTest, PeopleAreFoundAsTheRaysOfTheObservationSeeThem) {
  Experiment experiment = HallExperiment();
  experiment.world.persons = 1;
  experiment.world.person_radius = 0.05;
  const auto scene = MakeScene(experiment);
  scene->SetTable(MakeChain(scene->goal(), {0.5f, 1.0f, 1.5f, 2.0f, 2.5f, 2.7f}, 0.5f, 0.05));
  Persons persons(*scene);
  persons.Reset({0.5, 0.5, 0}, true, {1, RandomPurpose::kPersons});
  const Vector3d person = persons.bodies().at(0).base;
  RangeFinder ranges(*scene, &persons, {1, RandomPurpose::kRanges}, 0);
  Findings findings;
  SurpriseFinder(*scene).LookAround(GroundState{person.x() - 0.3, person.y(), 0}, ranges, &findings);
  ASSERT_EQ(findings.found.size(), 1u);
  EXPECT_LT((findings.found[0] - person).norm(), 0.05);
}

TEST_F(SurpriseFinderTest, ARayThroughAMarkFreesIt) {
  Experiment experiment = MakeExperiment(false);
  for (const bool shut : {true, false}) {
    if (!shut) experiment.world.blocked_doors.clear();
    auto scene = MakeScene(experiment);
    CostTable table = scene->lookup().table();
    const Vector3d door = scene->world().doors[3].center();
    table.marks = {static_cast<float>(door.x()), static_cast<float>(door.y()), 0};
    table.mark_reach = 0.05f;
    std::vector<float> positions;
    for (int v = 0; v < scene->lookup().num_vertices(); ++v) {
      positions.push_back(static_cast<float>(scene->lookup().position(v).x()));
      positions.push_back(static_cast<float>(scene->lookup().position(v).y()));
    }
    scene->SetTable(std::make_shared<RoadmapLookup>(2, positions, table, experiment.planner.r_ball()));
    EXPECT_EQ(Look(*scene, BeforeTheDoor(*scene)).freed.size(), shut ? 0u : 1u);
  }
}

TEST_F(SurpriseFinderTest, AContactIsAFindingOnlyWhereNothingIsKnown) {
  const auto scene = MakeScene(MakeExperiment(false));
  Motion motion = BeforeTheDoor(*scene);
  motion.vx = 0.3;
  Findings findings;
  SurpriseFinder(*scene).Touch(motion, &findings);
  ASSERT_EQ(findings.found.size(), 1u);
  const Vector3d way = findings.found[0] - Vector3d(motion.x, motion.y, 0);
  EXPECT_NEAR(way.norm(), scene->experiment().vehicle.circumscribed_radius(), 1e-12);
  EXPECT_NEAR(std::atan2(way.y(), way.x()), motion.yaw, 1e-12);
  motion.x = motion.y = 0.0;  // in the outer wall
  findings = {};
  SurpriseFinder(*scene).Touch(motion, &findings);
  EXPECT_TRUE(findings.found.empty());
  EXPECT_TRUE(findings.freed.empty());
}

}  // namespace
}  // namespace cairn::actors
