#pragma once

#include <ompl/base/Planner.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "common/roadmap/roadmap.h"
#include "planner/builders/point_tree.h"

namespace cairn::planner {

/// Rapidly-exploring random graph (Karaman and Frazzoli 2011; the paper's "RRG with Dijkstra Distance Calculation",
/// lines 1–19) in R² or R³. The problem's start states become the first vertices; `solve` grows the graph until its
/// termination condition says stop, then reports a path when a vertex satisfies the problem's goal. Cairn roots it in
/// the world's goal region, so that every vertex reaches the goal. One thread.
class Rrg : public ompl::base::Planner {
 public:
  explicit Rrg(const ompl::base::SpaceInformationPtr& information);

  /// Steering step and radius of Near [m], > 0. Karaman and Frazzoli's radius is min(γ (log n / n)^(1/d), η), and at
  /// the densities that min_spacing allows the ball is the larger one: η. Costs become taut afterwards (taut_ways.h).
  void SetEta(double eta) { eta_ = eta; }
  /// A new vertex nearer than this [m] to an existing one is not added (0: all are).
  void SetMinSpacing(double min_spacing) { min_spacing_ = min_spacing; }
  /// Called with the position of each vertex as it joins.
  void SetVertexObserver(std::function<void(const Vector3d&)> observer) { observer_ = std::move(observer); }

  /// Adds those of `samples` as vertices, whatever min_spacing says, that show a passage the graph lacks: of two
  /// vertices within eta of the sample and in straight reach of it, one has a cost to the roots that is more than
  /// `jump` [m] longer than the way through the sample. Goes on until none does; returns how many it added. Without it
  /// a corridor can stay open at a spot that the share of covered space is too coarse to notice.
  int ConnectPassages(const std::vector<Vector3d>& samples, double jump);

  void setup() override;
  void clear() override;
  ompl::base::PlannerStatus solve(const ompl::base::PlannerTerminationCondition& stop) override;
  void getPlannerData(ompl::base::PlannerData& data) const override;

  /// The graph so far; neighbours ascending.
  Roadmap roadmap() const;

  /// Samples drawn so far.
  int64_t num_samples() const { return num_samples_; }

 private:
  // Of a vertex near a sample: cost less and plus its distance to it [m].
  struct Bounds {
    double high, low;
    int32_t vertex;
  };

  void Grow(ompl::base::State* sample);
  bool MotionFree(const Vector3d& a, const Vector3d& b) const;
  void AddVertex(const Vector3d& p, int nearest);
  Vector3d Steer(const Vector3d& from, const Vector3d& to) const;
  bool ReportPath();
  bool ShowsPassage(const Vector3d& sample, const std::vector<float>& cost, double jump);

  int dimension_;
  double eta_ = 0;
  double min_spacing_ = 0;
  std::function<void(const Vector3d&)> observer_;
  ompl::base::ValidStateSamplerPtr sampler_;
  PointTree vertices_;
  std::vector<int32_t> roots_;
  std::vector<std::vector<int32_t>> neighbors_;  // per vertex, both ways
  std::vector<int32_t> near_;                    // scratch
  std::vector<Bounds> bounds_;                   // scratch
  int64_t num_samples_ = 0;
};

}  // namespace cairn::planner
