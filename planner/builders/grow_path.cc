#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/StateSampler.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRT.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>

#include <cmath>
#include <memory>

#include "common/core/check.h"
#include "planner/builders/builder.h"
#include "planner/builders/coverage.h"
#include "planner/collision/ompl_space.h"

namespace cairn::planner {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

constexpr double kGoalBias = 0.05;  // OMPL's default for both trees
constexpr int kStartSamples = 1000;

// Uniform in the bounds, now and then in the goal region. The trees' own goal bias and samplers draw from OMPL's global
// generator, whose seed works once in a process; this one repeats.
class TreeSampler : public ob::StateSampler {
 public:
  TreeSampler(const ob::StateSpace* space, const World& world, uint64_t seed, int64_t* count)
      : ob::StateSampler(space), world_(world), random_(seed, RandomPurpose::kPlanner), count_(count) {}

  void sampleUniform(ob::State* state) override {
    ++*count_;
    const Box& region = random_.Uniform() < kGoalBias ? world_.goal : world_.bounds;
    Vector3d p = Vector3d::Zero();
    for (int k = 0; k < world_.dimension; ++k) p[k] = random_.Uniform(region.min[k], region.max[k]);
    ToState(RoundToFloat(p, world_.dimension), world_.dimension, state);
  }

  // Neither tree asks for these.
  void sampleUniformNear(ob::State*, const ob::State*, double) override { ThrowError("TreeSampler: only uniform"); }
  void sampleGaussian(ob::State*, const ob::State*, double) override { ThrowError("TreeSampler: only uniform"); }

 private:
  const World& world_;
  RandomStream random_;
  int64_t* count_;
};

// The free point of the start region nearest to its centre, of some.
Vector3d ChooseStart(const BuildTask& task) {
  const World& world = task.space.world();
  const Vector3d center = RoundToFloat(world.start.center(), world.dimension);
  if (task.space.Contains(center)) return center;
  RandomStream random(task.config.seed, RandomPurpose::kPlanner, 2);
  std::optional<Vector3d> best;
  for (int i = 0; i < kStartSamples; ++i) {
    const std::optional<Vector3d> p = task.space.Draw(world.start, random);
    if (!p) break;
    if (!best || (*p - center).norm() < (*best - center).norm()) best = p;
  }
  if (!best) {
    ThrowUsageError("world.start: no point of it is free for planner.radius = {} m by exact test", task.config.radius);
  }
  return *best;
}

class Tree {
 public:
  explicit Tree(const BuildTask& task)
      : task_(task), config_(task.config), information_(MakeSpaceInformation(task.space, config_.seed)) {
    information_->getStateSpace()->setStateSamplerAllocator([this](const ob::StateSpace* space) {
      return std::make_shared<TreeSampler>(space, task_.space.world(), config_.seed, &samples_);
    });
    const World& world = task.space.world();
    problem_ = MakeProblem(information_, {ChooseStart(task)}, MakeRegionGoal(information_, world, world.goal));
  }

  Grown Grow() {
    config_.kind == PlannerConfig::Kind::kRrt ? SolveRrt() : SolveRrtStar();
    if (!problem_->hasExactSolution()) {
      ThrowUsageError("planner.max_samples = {}: reached without a path from world.start to world.goal",
                      config_.max_samples);
    }
    const std::vector<Vector3d> points = Vertices(*problem_->getSolutionPath()->as<og::PathGeometric>());
    Coverage coverage(task_.space, config_.r_ball(), kCoverageSamples, config_.seed);
    for (const Vector3d& p : points) coverage.AddVertex(p);
    return {Chain(points), samples_, coverage.share()};
  }

 private:
  void SolveRrt() {
    og::RRT tree(information_);
    tree.setProblemDefinition(problem_);
    tree.setRange(config_.eta);
    tree.setup();
    tree.solve(ob::PlannerTerminationCondition([this] { return samples_ >= config_.max_samples; }));
  }

  void SolveRrtStar() {
    og::RRTstar tree(information_);
    tree.setProblemDefinition(problem_);
    tree.setRange(config_.eta);
    tree.setup();
    tree.solve(ob::PlannerTerminationCondition([&] {
      const bool enough = samples_ >= config_.path_samples && std::isfinite(tree.bestCost().value());
      return enough || samples_ >= config_.max_samples;
    }));
  }

  // The path's states and as many points between them that the balls about them leave no gap.
  std::vector<Vector3d> Vertices(const og::PathGeometric& path) const {
    const int dimension = task_.space.world().dimension;
    const double spacing = config_.min_spacing > 0 ? config_.min_spacing : config_.r_ball();
    std::vector<Vector3d> points{ToPosition(path.getState(0), dimension)};
    for (size_t i = 1; i < path.getStateCount(); ++i) {
      const Vector3d from = points.back(), to = ToPosition(path.getState(i), dimension);
      const int parts = std::max(1, static_cast<int>(std::ceil((to - from).norm() / spacing - 1e-6)));
      const size_t first = points.size();
      for (int part = 1; part < parts; ++part)
        points.push_back(RoundToFloat(from + (to - from) * part / parts, dimension));
      points.push_back(to);
      if (parts == 1 || AllFree(points, first)) continue;
      points.resize(first);  // rounding made a close shave a touch
      points.push_back(to);
    }
    return points;
  }

  bool AllFree(const std::vector<Vector3d>& points, size_t first) const {
    for (size_t i = first; i < points.size(); ++i) {
      if (!task_.space.checker().MotionFree(points[i - 1], points[i])) return false;
    }
    return true;
  }

  Roadmap Chain(const std::vector<Vector3d>& points) const {
    Roadmap roadmap;
    roadmap.dimension = task_.space.world().dimension;
    roadmap.offsets.push_back(0);
    for (size_t i = 0; i < points.size(); ++i) {
      for (int k = 0; k < roadmap.dimension; ++k) roadmap.positions.push_back(static_cast<float>(points[i][k]));
      const auto join = [&](size_t other) {
        roadmap.neighbors.push_back(static_cast<int32_t>(other));
        roadmap.lengths.push_back(static_cast<float>((points[other] - points[i]).norm()));
      };
      if (i > 0) join(i - 1);
      if (i + 1 < points.size()) join(i + 1);
      roadmap.offsets.push_back(static_cast<int32_t>(roadmap.neighbors.size()));
    }
    return roadmap;
  }

  const BuildTask& task_;
  const PlannerConfig& config_;
  int64_t samples_ = 0;
  ob::SpaceInformationPtr information_;
  ob::ProblemDefinitionPtr problem_;
};

}  // namespace

Grown GrowPath(const BuildTask& task) { return Tree(task).Grow(); }

}  // namespace cairn::planner
