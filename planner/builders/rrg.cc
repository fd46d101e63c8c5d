#include "planner/builders/rrg.h"

#include <ompl/base/PlannerData.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/ScopedState.h>
#include <ompl/geometric/PathGeometric.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/core/check.h"
#include "planner/builders/to_roadmap.h"
#include "planner/collision/free_space.h"
#include "planner/collision/ompl_space.h"
#include "planner/cost_to_go.h"

namespace cairn::planner {

namespace ob = ompl::base;

Rrg::Rrg(const ob::SpaceInformationPtr& information)
    : ob::Planner(information, "RRG"),
      dimension_(static_cast<int>(information->getStateDimension())),
      vertices_(dimension_) {
  CAIRN_CHECK(dimension_ == 2 || dimension_ == 3, "dimension {}", dimension_);
  specs_.optimizingPaths = true;
}

void Rrg::setup() {
  ob::Planner::setup();
  CAIRN_CHECK(eta_ > 0, "SetEta was not called");
}

void Rrg::clear() {
  ob::Planner::clear();
  sampler_.reset();
  vertices_.Clear();
  roots_.clear();
  neighbors_.clear();
  num_samples_ = 0;
}

ob::PlannerStatus Rrg::solve(const ob::PlannerTerminationCondition& stop) {
  checkValidity();
  while (const ob::State* start = pis_.nextStart()) {
    roots_.push_back(vertices_.size());
    AddVertex(RoundToFloat(ToPosition(start, dimension_), dimension_), -1);
  }
  if (roots_.empty()) return ob::PlannerStatus::INVALID_START;
  if (!sampler_) sampler_ = si_->allocValidStateSampler();
  ob::ScopedState<> sample(si_);
  while (!stop) Grow(sample.get());
  return ReportPath() ? ob::PlannerStatus::EXACT_SOLUTION : ob::PlannerStatus::TIMEOUT;
}

// One iteration of the paper's loop: Sample, Nearest, Steer, CollisionFree, connect to all of Near.
void Rrg::Grow(ob::State* sample) {
  ++num_samples_;
  if (!sampler_->sample(sample)) return;
  const Vector3d target = ToPosition(sample, dimension_);
  if (vertices_.AnyNearer(target, min_spacing_)) return;  // the fate of most samples
  const int nearest = vertices_.Nearest(target);
  const Vector3d& from = vertices_.point(nearest);
  // Steering keeps the nearest vertex nearest, so one distance decides on the spacing.
  const double distance = (target - from).norm();
  if (distance < min_spacing_ || distance == 0) return;
  const Vector3d p = Steer(from, target);
  if (MotionFree(from, p)) AddVertex(p, nearest);
}

Vector3d Rrg::Steer(const Vector3d& from, const Vector3d& to) const {
  const double distance = (to - from).norm();
  return distance <= eta_ ? to : RoundToFloat(from + (to - from) * (eta_ / distance), dimension_);
}

bool Rrg::MotionFree(const Vector3d& a, const Vector3d& b) const {
  ob::ScopedState<> from(si_), to(si_);
  ToState(a, dimension_, from.get());
  ToState(b, dimension_, to.get());
  return si_->checkMotion(from.get(), to.get());
}

// `nearest`: the vertex whose motion to p is known to be free, −1 for roots.
void Rrg::AddVertex(const Vector3d& p, int nearest) {
  vertices_.Within(p, eta_, near_);
  const int32_t vertex = vertices_.size();
  vertices_.Add(p);
  neighbors_.emplace_back();
  const auto connect = [&](int32_t other) {
    neighbors_[vertex].push_back(other);
    neighbors_[other].push_back(vertex);
  };
  if (nearest >= 0) connect(nearest);
  for (const int32_t other : near_) {
    if (other != nearest && MotionFree(vertices_.point(other), p)) connect(other);
  }
  if (observer_) observer_(p);
}

// Of the vertices around the sample only the two with extreme bounds matter: the one whose cost less its distance is
// highest and the one whose cost plus its distance is lowest. Each is tested for straight reach when its turn comes and
// dropped when it has none, so that few motions are tested.
bool Rrg::ShowsPassage(const Vector3d& sample, const std::vector<float>& cost, double jump) {
  vertices_.Within(sample, eta_, near_);
  bounds_.clear();
  for (const int32_t v : near_) {
    const double distance = (vertices_.point(v) - sample).norm();
    bounds_.push_back({cost[v] - distance, cost[v] + distance, v});
  }
  const auto less_high = [](const Bounds& a, const Bounds& b) { return a.high < b.high; };
  const auto less_low = [](const Bounds& a, const Bounds& b) { return a.low < b.low; };
  while (!bounds_.empty()) {
    const auto high = std::max_element(bounds_.begin(), bounds_.end(), less_high);
    const auto low = std::min_element(bounds_.begin(), bounds_.end(), less_low);
    if (high->high - low->low <= jump) return false;
    const bool high_free = MotionFree(vertices_.point(high->vertex), sample);
    if (high_free && MotionFree(vertices_.point(low->vertex), sample)) return true;
    bounds_.erase(high_free ? low : high);
  }
  return false;
}

int Rrg::ConnectPassages(const std::vector<Vector3d>& samples, double jump) {
  const int before = vertices_.size();
  for (bool again = true; again;) {
    again = false;
    std::vector<float> cost = ComputeShortestPaths(roadmap(), roots_).cost;
    for (const Vector3d& sample : samples) {
      if (!ShowsPassage(sample, cost, jump)) continue;
      AddVertex(sample, -1);
      cost = ComputeShortestPaths(roadmap(), roots_).cost;
      again = true;
    }
  }
  return vertices_.size() - before;
}

Roadmap Rrg::roadmap() const { return ToRoadmap(dimension_, vertices_, neighbors_); }

// Adds the shortest path from a root to a vertex that satisfies the problem's goal; false when none does.
bool Rrg::ReportPath() {
  const ShortestPaths paths = ComputeShortestPaths(roadmap(), roots_);
  ob::ScopedState<> state(si_);
  int best = -1;
  for (int v = 0; v < vertices_.size(); ++v) {
    ToState(vertices_.point(v), dimension_, state.get());
    const bool shorter = best < 0 || paths.cost[v] < paths.cost[best];
    if (shorter && std::isfinite(paths.cost[v]) && pdef_->getGoal()->isSatisfied(state.get())) best = v;
  }
  if (best < 0) return false;
  auto path = std::make_shared<ompl::geometric::PathGeometric>(si_);
  for (int v = best; v >= 0; v = paths.next_vertex[v]) {
    ToState(vertices_.point(v), dimension_, state.get());
    path->append(state.get());
  }
  path->reverse();
  pdef_->addSolutionPath(path, false, 0.0, getName());
  return true;
}

void Rrg::getPlannerData(ob::PlannerData& data) const {
  ob::Planner::getPlannerData(data);
  std::vector<ob::State*> states(vertices_.size());
  for (int v = 0; v < vertices_.size(); ++v) {
    states[v] = si_->allocState();
    ToState(vertices_.point(v), dimension_, states[v]);
    const bool root = std::find(roots_.begin(), roots_.end(), v) != roots_.end();
    const ob::PlannerDataVertex vertex(states[v]);
    root ? data.addStartVertex(vertex) : data.addVertex(vertex);
  }
  for (int v = 0; v < vertices_.size(); ++v) {
    for (const int32_t other : neighbors_[v]) {
      const double length = (vertices_.point(v) - vertices_.point(other)).norm();
      data.addEdge(v, other, ob::PlannerDataEdge(), ob::Cost(length));
    }
  }
  data.decoupleFromPlanner();  // copies the states
  for (ob::State* state : states) si_->freeState(state);
}

}  // namespace cairn::planner
