#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/geometric/planners/prm/PRMstar.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/builders/builder.h"
#include "planner/builders/coverage.h"
#include "planner/collision/ompl_space.h"
#include "planner/cost_to_go.h"

namespace cairn::planner {
namespace {

namespace ob = ompl::base;

// OMPL's PRM* (Karaman and Frazzoli 2011), grown by number: `solve` would alternate between growing and expanding by
// the wall clock. Samples come from the space's valid-state sampler alone, so the graph repeats.
class PrmStar : public ompl::geometric::PRMstar {
 public:
  explicit PrmStar(const ob::SpaceInformationPtr& information)
      : PRMstar(information), dimension_(static_cast<int>(information->getStateDimension())) {}

  void Add(const Vector3d& p) {
    ob::State* state = si_->allocState();  // the graph's from here
    ToState(p, dimension_, state);
    addMilestone(state);
  }

  void GrowTo(int milestones) {
    growRoadmap(ob::PlannerTerminationCondition([&] { return num_milestones() >= milestones; }));
  }

  int num_milestones() const { return static_cast<int>(milestoneCount()); }
  Vector3d position(int milestone) const {
    return ToPosition(boost::get(vertex_state_t(), getRoadmap(), static_cast<Vertex>(milestone)), dimension_);
  }

  // The milestones that are in `keep`, as they were added; neighbours ascending.
  Roadmap MakeRoadmap(const std::vector<char>& keep) const {
    std::vector<int32_t> vertex(keep.size(), -1);
    int32_t count = 0;
    for (size_t m = 0; m < keep.size(); ++m) vertex[m] = keep[m] ? count++ : -1;
    Roadmap roadmap;
    roadmap.dimension = dimension_;
    roadmap.offsets.push_back(0);
    for (size_t m = 0; m < keep.size(); ++m) {
      if (keep[m]) AppendVertex(static_cast<int>(m), vertex, &roadmap);
    }
    return roadmap;
  }

 private:
  void AppendVertex(int milestone, const std::vector<int32_t>& vertex, Roadmap* roadmap) const {
    const Vector3d p = position(milestone);
    for (int k = 0; k < dimension_; ++k) roadmap->positions.push_back(static_cast<float>(p[k]));
    std::vector<std::pair<int32_t, double>> edges;
    const auto [first, last] = boost::adjacent_vertices(static_cast<Vertex>(milestone), getRoadmap());
    for (auto other = first; other != last; ++other) {
      if (vertex[*other] >= 0) edges.emplace_back(vertex[*other], (position(static_cast<int>(*other)) - p).norm());
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    for (const auto& [neighbor, length] : edges) {
      roadmap->neighbors.push_back(neighbor);
      roadmap->lengths.push_back(static_cast<float>(length));
    }
    roadmap->offsets.push_back(static_cast<int32_t>(roadmap->neighbors.size()));
  }

  int dimension_;
};

// Grows until what is joined to the roots covers free space.
class Growth {
 public:
  explicit Growth(const BuildTask& task)
      : config_(task.config),
        coverage_(task.space, config_.r_ball(), kCoverageSamples, config_.seed),
        prm_(MakeSpaceInformation(task.space, config_.seed)) {
    const std::vector<Vector3d> roots = ChooseRoots(task);
    const World& world = task.space.world();
    const ob::SpaceInformationPtr& information = prm_.getSpaceInformation();
    prm_.setProblemDefinition(MakeProblem(information, roots, MakeRegionGoal(information, world, world.start)));
    prm_.setup();
    for (const Vector3d& root : roots) prm_.Add(root);
    for (int32_t i = 0; i < prm_.num_milestones(); ++i) roots_.push_back(i);
  }

  Grown Run() {
    int target = kFirst;
    for (;; target += target / 8) {
      target = std::min(target, config_.max_samples);
      prm_.GrowTo(target);
      CountJoined();
      if (coverage_.share() >= config_.coverage) break;
      if (target == config_.max_samples) ThrowSampleCap(config_, coverage_.share());
    }
    return {prm_.MakeRoadmap(joined_), prm_.num_milestones(), coverage_.share()};
  }

 private:
  static constexpr int kFirst = 1000;  // milestones

  void CountJoined() {
    const auto count = static_cast<size_t>(prm_.num_milestones());
    const ShortestPaths paths = ComputeShortestPaths(prm_.MakeRoadmap(std::vector<char>(count, 1)), roots_);
    joined_.resize(count, 0);
    for (size_t m = 0; m < count; ++m) {
      if (joined_[m] || !std::isfinite(paths.cost[m])) continue;
      joined_[m] = 1;
      coverage_.AddVertex(prm_.position(static_cast<int>(m)));
    }
  }

  const PlannerConfig& config_;
  Coverage coverage_;
  PrmStar prm_;
  std::vector<int32_t> roots_;
  std::vector<char> joined_;  // per milestone
};

}  // namespace

Grown GrowPrmStar(const BuildTask& task) { return Growth(task).Run(); }

}  // namespace cairn::planner
