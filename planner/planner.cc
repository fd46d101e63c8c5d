#include "planner/planner.h"

#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/ScopedState.h>
#include <ompl/util/Console.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "common/core/check.h"
#include "common/core/clock.h"
#include "common/world/reachability.h"
#include "planner/builders/coverage.h"
#include "planner/builders/rrg.h"
#include "planner/collision/free_space.h"
#include "planner/collision/ompl_space.h"
#include "planner/collision/swept_sphere_checker.h"
#include "planner/through_walls.h"

namespace cairn::planner {
namespace {

namespace ob = ompl::base;

constexpr int kCoverageSamples = 20000;
constexpr int kRootSamples = 1000;

// Smallest extent of any obstacle [m], infinite without obstacles.
double ThinnestWall(const World& world) {
  double thinnest = std::numeric_limits<double>::infinity();
  for (const Box& box : world.boxes) {
    for (int k = 0; k < world.dimension; ++k) thinnest = std::min(thinnest, box.size()[k]);
  }
  for (const Cylinder& cylinder : world.cylinders) {
    thinnest = std::min(thinnest, 2 * cylinder.radius);
    if (world.dimension == 3) thinnest = std::min(thinnest, cylinder.height);
  }
  return thinnest;
}

// The largest number of four digits below x > 0.
double FourDigitsBelow(double x) {
  const double unit = std::pow(10, std::floor(std::log10(x)) - 3);
  return (std::ceil(x / unit * (1 - 1e-9)) - 1) * unit;
}

// D(s) reads through a wall when a vertex on its far side (planning radius away) comes within r_ball of a robot that
// touches its near side (inscribed radius away).
void CheckConfig(const World& world, const PlannerConfig& config, double inscribed_radius) {
  if (!(config.eta > 0)) ThrowUsageError("planner.eta = {} m: must be > 0", config.eta);
  if (!(config.radius > 0)) ThrowUsageError("planner.radius = {} m: must be > 0", config.radius);
  const double limit = ThinnestWall(world) + config.radius + inscribed_radius;
  if (!world.imported && !(config.r_ball() < limit)) {  // of imported maps see CheckCostsBehindWalls
    ThrowUsageError(
        "planner.eta = {} m: r_ball = eta / 2 must be less than thinnest wall + planner.radius + inscribed radius = "
        "{:.6g} m, or costs are read through walls; the largest eta that passes is {:.6g} m",
        config.eta, limit, FourDigitsBelow(2 * limit));
  }
  if (!(config.min_spacing >= 0 && config.min_spacing <= config.r_ball())) {
    ThrowUsageError("planner.min_spacing = {} m: must be in [0, {:.6g}] (eta / 2), or vertices cannot cover free space",
                    config.min_spacing, config.r_ball());
  }
}

// First vertices: the goal region's roomiest point and what fits beside it at the spacing, so that a goal region of
// several parts is entered everywhere.
std::vector<Vector3d> ChooseRoots(const FreeSpace& space, const Vector3d& goal_point, const PlannerConfig& config) {
  const World& world = space.world();
  const double spacing = std::max(config.min_spacing, 0.25 * config.eta);
  RandomStream random(config.seed, RandomPurpose::kPlanner, 2);
  std::vector<Vector3d> roots;
  for (int i = 0; i < kRootSamples; ++i) {
    Vector3d p = RoundToFloat(goal_point, world.dimension);
    if (i > 0) {
      for (int k = 0; k < world.dimension; ++k) p[k] = random.Uniform(world.goal.min[k], world.goal.max[k]);
      p = RoundToFloat(p, world.dimension);
    }
    const auto too_near = [&](const Vector3d& root) { return (root - p).norm() < spacing; };
    const bool fits = std::none_of(roots.begin(), roots.end(), too_near);
    if (fits && world.Contains(world.goal, p) && space.Contains(p)) roots.push_back(p);
  }
  return roots;
}

ob::ProblemDefinitionPtr MakeProblem(const ob::SpaceInformationPtr& information, const World& world,
                                     const std::vector<Vector3d>& roots) {
  auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<> state(information);
  for (const Vector3d& root : roots) {
    ToState(root, world.dimension, state.get());
    problem->addStartState(state);
  }
  problem->setGoal(MakeRegionGoal(information, world, world.start));
  return problem;
}

int CountComponents(const Roadmap& roadmap) {
  std::vector<char> seen(roadmap.num_vertices(), 0);
  std::vector<int32_t> stack;
  int components = 0;
  for (int32_t root = 0; root < roadmap.num_vertices(); ++root) {
    if (seen[root]) continue;
    ++components;
    seen[root] = 1;
    stack.push_back(root);
    while (!stack.empty()) {
      const int32_t v = stack.back();
      stack.pop_back();
      for (int32_t e = roadmap.offsets[v]; e < roadmap.offsets[v + 1]; ++e) {
        const int32_t u = roadmap.neighbors[e];
        if (!seen[u]) stack.push_back(u);
        seen[u] = 1;
      }
    }
  }
  return components;
}

}  // namespace

void CheckPlannable(const World& world, const DistanceField& field, const PlannerConfig& config,
                    double inscribed_radius) {
  CheckConfig(world, config, inscribed_radius);
  Reachability(world, field, config.radius).CheckStart();
}

BuiltRoadmap BuildRoadmap(const World& world, const DistanceField& field, const PlannerConfig& config,
                          double inscribed_radius) {
  const TimePoint start = Clock::now();
  ompl::msg::setLogLevel(ompl::msg::LOG_WARN);
  CheckConfig(world, config, inscribed_radius);
  const Reachability reachability(world, field, config.radius);
  reachability.CheckStart();
  const SweptSphereChecker checker(world, config.radius, &field);
  const FreeSpace space(world, checker, reachability);
  Coverage coverage(space, config.r_ball(), kCoverageSamples, config.seed);
  const std::vector<Vector3d> roots = ChooseRoots(space, reachability.goal_point(), config);
  if (roots.empty()) {
    ThrowUsageError("world.goal: no point of it is free for planner.radius = {} m by exact test", config.radius);
  }

  const ob::SpaceInformationPtr information = MakeSpaceInformation(space, config.seed);
  Rrg rrg(information);
  rrg.SetEta(config.eta);
  rrg.SetMinSpacing(config.min_spacing);
  rrg.SetVertexObserver([&](const Vector3d& p) { coverage.AddVertex(p); });
  rrg.setProblemDefinition(MakeProblem(information, world, roots));
  rrg.setup();
  // The graph grows on samples of its own; every vertex hangs on a root in the goal region, so what is covered is
  // connected to the goal.
  const auto done = [&] { return coverage.share() >= config.coverage || rrg.num_samples() >= config.max_samples; };
  rrg.solve(ob::PlannerTerminationCondition(done));
  if (coverage.share() < config.coverage) {
    ThrowUsageError("planner.max_samples = {}: reached with coverage {:.5f} of free space, below planner.coverage = {}",
                    config.max_samples, coverage.share(), config.coverage);
  }
  const double share = coverage.share();
  rrg.ConnectPassages(coverage.samples(), 2 * config.r_ball());

  BuiltRoadmap built{rrg.roadmap(), {}};
  built.info.vertices = built.roadmap.num_vertices();
  built.info.edges = built.roadmap.num_edges();
  built.info.samples = static_cast<int>(rrg.num_samples());
  built.info.coverage = share;
  built.info.components = CountComponents(built.roadmap);
  if (world.imported) {
    CheckCostsBehindWalls(world, field, built.roadmap, ComputeCostTable(built.roadmap, world, world.goal), config,
                          inscribed_radius);
  }
  built.info.build_s = SecondsSince(start);
  return built;
}

}  // namespace cairn::planner
