#include "planner/builders/rrg.h"

#include <gtest/gtest.h>
#include <ompl/base/PlannerData.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/ScopedState.h>

#include <algorithm>
#include <memory>

#include "common/world/reachability.h"
#include "planner/collision/ompl_space.h"
#include "planner/cost_to_go.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

namespace ob = ompl::base;

constexpr double kEta = 0.15, kRadius = 0.04;

// An OMPL problem: from a state in one room to a region in the other.
class RrgTest : public testing::TestWithParam<int> {
 protected:
  RrgTest() {
    ob::ScopedState<> start(information_);
    ToState(Vector3d(1.8, 0.8, 0.25), GetParam(), start.get());
    problem_->addStartState(start);
    problem_->setGoal(MakeRegionGoal(information_, world_, world_.start));
    rrg_.SetEta(kEta);
    rrg_.setProblemDefinition(problem_);
    rrg_.setup();
  }

  ob::PlannerStatus::StatusType Solve(int samples) {
    return rrg_.solve(ob::PlannerTerminationCondition([&, samples] { return rrg_.num_samples() >= samples; }));
  }

  World world_ = TwoRooms(GetParam());
  DistanceField field_{world_, 0.01};
  Reachability reachability_{world_, field_, kRadius};
  SweptSphereChecker checker_{world_, kRadius};
  FreeSpace space_{world_, checker_, reachability_};
  ob::SpaceInformationPtr information_ = MakeSpaceInformation(space_, 5);
  ob::ProblemDefinitionPtr problem_ = std::make_shared<ob::ProblemDefinition>(information_);
  Rrg rrg_{information_};
};

TEST_P(RrgTest, SolvesAnOmplProblemWithAValidPath) {
  ASSERT_EQ(Solve(4000), ob::PlannerStatus::EXACT_SOLUTION);
  const ob::PathPtr path = problem_->getSolutionPath();
  ASSERT_TRUE(path);
  EXPECT_TRUE(path->check());
  EXPECT_GT(path->length(), 1.5);  // corner to corner through the door
  EXPECT_LT(path->length(), 2.6);
}

TEST_P(RrgTest, SaysSoWhenTheGoalIsNotReachedYet) {
  EXPECT_EQ(Solve(3), ob::PlannerStatus::TIMEOUT);
  EXPECT_FALSE(problem_->hasSolution());
}

TEST_P(RrgTest, EdgesAreShortFreeAndBothWays) {
  Solve(2000);
  const Roadmap roadmap = rrg_.roadmap();
  ASSERT_GT(roadmap.num_edges(), 2 * roadmap.num_vertices());
  for (int v = 0; v < roadmap.num_vertices(); ++v) {
    for (int e = roadmap.offsets[v]; e < roadmap.offsets[v + 1]; ++e) {
      const int u = roadmap.neighbors[e];
      const Vector3d p = roadmap.position(v), q = roadmap.position(u);
      ASSERT_NEAR(roadmap.lengths[e], (p - q).norm(), 1e-6);
      ASSERT_LE(roadmap.lengths[e], kEta + 1e-6);
      ASSERT_GT(LeastDistance(world_, p, q), kRadius - 1e-5);
      const auto begin = roadmap.neighbors.begin();
      ASSERT_TRUE(std::binary_search(begin + roadmap.offsets[u], begin + roadmap.offsets[u + 1], v));
    }
  }
}

// RRG's definition: an edge to every vertex within eta that can be reached in a straight line.
TEST_P(RrgTest, NoFreeEdgeWithinEtaIsMissing) {
  Solve(600);
  const Roadmap roadmap = rrg_.roadmap();
  for (int v = 0; v < roadmap.num_vertices(); ++v) {
    for (int u = 0; u < v; ++u) {
      const Vector3d p = roadmap.position(v), q = roadmap.position(u);
      if ((p - q).norm() > kEta * (1 - 1e-6) || LeastDistance(world_, p, q) < kRadius + 1e-3) continue;
      const auto begin = roadmap.neighbors.begin();
      EXPECT_TRUE(std::binary_search(begin + roadmap.offsets[u], begin + roadmap.offsets[u + 1], v)) << u << ", " << v;
    }
  }
}

TEST_P(RrgTest, VerticesKeepTheirSpacing) {
  rrg_.SetMinSpacing(0.08);
  Solve(3000);
  const Roadmap roadmap = rrg_.roadmap();
  ASSERT_GT(roadmap.num_vertices(), 50);
  for (int v = 0; v < roadmap.num_vertices(); ++v) {
    for (int u = 0; u < v; ++u) EXPECT_GE((roadmap.position(u) - roadmap.position(v)).norm(), 0.08 - 1e-6);
  }
}

TEST(RrgPassageTest, SamplesThatShowAMissingPassageAreAdded) {
  World world;
  world.bounds = {Vector3d(0, 0, 0), Vector3d(2, 2, 0)};
  world.boxes = {{Vector3d(0.99, 0.3, 0), Vector3d(1.01, 1.4, 0)}};  // open below (0.3 m) and above
  world.start = world.goal = {Vector3d(1.5, 0.1, 0), Vector3d(1.8, 0.2, 0)};
  const DistanceField field(world, 0.01);
  const Reachability reachability(world, field, kRadius);
  const SweptSphereChecker checker(world, kRadius);
  const FreeSpace space(world, checker, reachability);
  const ob::SpaceInformationPtr information = MakeSpaceInformation(space, 1);
  const auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<> state(information);
  ToState(Vector3d(1.2, 0.15, 0), 2, state.get());
  problem->addStartState(state);
  problem->setGoal(MakeRegionGoal(information, world, world.goal));
  Rrg rrg(information);
  rrg.SetEta(0.25);
  rrg.SetMinSpacing(0.2);
  rrg.setProblemDefinition(problem);
  rrg.setup();
  rrg.solve(ob::PlannerTerminationCondition([&] { return rrg.num_samples() >= 20000; }));

  // What the samples promise: no two vertices in sight of one differ in cost by more than the way through it and eta.
  std::vector<Vector3d> samples;
  RandomStream random(3, RandomPurpose::kTest);
  while (samples.size() < 3000) {
    const Vector3d p = RoundToFloat(DrawIn(world, random), 2);
    if (checker.Free(p)) samples.push_back(p);
  }
  EXPECT_GT(rrg.ConnectPassages(samples, 0.1), 0);  // so sparse a graph lacks some
  const Roadmap roadmap = rrg.roadmap();
  const std::vector<float> cost = ComputeShortestPaths(roadmap, std::vector<int32_t>{0}).cost;
  for (const Vector3d& sample : samples) {
    double highest = -1e300, lowest = 1e300;
    for (int v = 0; v < roadmap.num_vertices(); ++v) {
      const double distance = (roadmap.position(v) - sample).norm();
      if (distance > 0.25 - 1e-6 || !checker.MotionFree(roadmap.position(v), sample)) continue;
      highest = std::max(highest, cost[v] - distance);
      lowest = std::min(lowest, cost[v] + distance);
    }
    EXPECT_LE(highest - lowest, 0.1 + 1e-6) << sample.transpose();
  }
  EXPECT_EQ(rrg.ConnectPassages(samples, 0.1), 0);
}

TEST_P(RrgTest, ClearStartsOverAndRepeats) {
  Solve(500);
  const Roadmap first = rrg_.roadmap();
  Solve(1000);
  EXPECT_GT(rrg_.roadmap().num_vertices(), first.num_vertices());  // solve goes on where it was
  rrg_.clear();
  EXPECT_EQ(rrg_.roadmap().num_vertices(), 0);
  Solve(500);
  EXPECT_EQ(rrg_.roadmap().positions, first.positions);
  EXPECT_EQ(rrg_.roadmap().neighbors, first.neighbors);
}

TEST_P(RrgTest, PlannerDataHoldsTheGraphWithLengths) {
  Solve(300);
  const Roadmap roadmap = rrg_.roadmap();
  ob::PlannerData data(information_);
  rrg_.getPlannerData(data);
  ASSERT_EQ(static_cast<int>(data.numVertices()), roadmap.num_vertices());
  ASSERT_EQ(static_cast<int>(data.numEdges()), 2 * roadmap.num_edges());
  EXPECT_EQ(data.numStartVertices(), 1u);
  ob::Cost cost;
  ASSERT_TRUE(data.getEdgeWeight(0, static_cast<unsigned>(roadmap.neighbors[0]), &cost));
  EXPECT_NEAR(cost.value(), roadmap.lengths[0], 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, RrgTest, testing::Values(2, 3));

}  // namespace
}  // namespace cairn::planner
