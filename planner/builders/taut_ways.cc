#include "planner/builders/taut_ways.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "planner/builders/bends.h"
#include "planner/builders/point_tree.h"
#include "planner/builders/to_roadmap.h"

namespace cairn::planner {
namespace {

constexpr double kReach = 2;          // of new edges, in eta
constexpr double kDetour = 1.02;      // a way over two edges of so many lengths makes an edge needless
constexpr size_t kBendsPerPlace = 3;  // at most: bounds memory and the time of a table

class Tautener {
 public:
  Tautener(const FreeSpace& space, double reach, const Roadmap& roadmap)
      : checker_(space.checker()),
        reach_(reach),
        dimension_(roadmap.dimension),
        tree_(roadmap.dimension),
        seen_from_(roadmap.num_vertices(), -1) {
    for (int32_t v = 0; v < roadmap.num_vertices(); ++v) {
      tree_.Add(roadmap.position(v));
      neighbors_.emplace_back(roadmap.neighbors.begin() + roadmap.offsets[v],
                              roadmap.neighbors.begin() + roadmap.offsets[v + 1]);
    }
  }

  // Edges from a vertex to those before it, shortest first.
  void Connect(int32_t vertex) {
    for (const int32_t other : neighbors_[vertex]) seen_from_[other] = vertex;
    for (const auto& [length, other] : NearestFirst(tree_.point(vertex), vertex)) {
      if (seen_from_[other] == vertex || length == 0 || HasDetour(vertex, other, kDetour * length)) continue;
      if (!checker_.MotionFree(tree_.point(other), tree_.point(vertex))) continue;
      neighbors_[vertex].push_back(other);
      neighbors_[other].push_back(vertex);
      seen_from_[other] = vertex;
    }
  }

  // A bend that sees no vertex would be an island.
  void AddBend(const Vector3d& p) {
    const auto sees = [&](const auto& near) { return checker_.MotionFree(tree_.point(near.second), p); };
    const auto near = NearestFirst(p, tree_.size());
    if (std::none_of(near.begin(), near.end(), sees)) return;
    tree_.Add(p);
    neighbors_.emplace_back();
    seen_from_.push_back(-1);
    Connect(tree_.size() - 1);
  }

  Roadmap Finish() const { return ToRoadmap(dimension_, tree_, neighbors_); }

 private:
  // Vertices below `end` within reach of p: distance and number.
  std::vector<std::pair<double, int32_t>> NearestFirst(const Vector3d& p, int32_t end) {
    std::vector<std::pair<double, int32_t>> near;
    tree_.Within(p, reach_, found_);
    for (const int32_t v : found_) {
      if (v < end) near.emplace_back((tree_.point(v) - p).norm(), v);
    }
    std::sort(near.begin(), near.end());
    return near;
  }

  bool HasDetour(int32_t vertex, int32_t other, double longest) const {
    return std::any_of(neighbors_[other].begin(), neighbors_[other].end(), [&](int32_t between) {
      if (seen_from_[between] != vertex) return false;
      const Vector3d& p = tree_.point(between);
      return (tree_.point(vertex) - p).norm() + (tree_.point(other) - p).norm() <= longest;
    });
  }

  const SweptSphereChecker& checker_;
  double reach_;  // [m]
  int dimension_;
  PointTree tree_;
  std::vector<std::vector<int32_t>> neighbors_;
  std::vector<int32_t> seen_from_;  // per vertex: the last one connected that is its neighbour
  std::vector<int32_t> found_;      // scratch
};

}  // namespace

void AddTautWays(const FreeSpace& space, double eta, Roadmap* roadmap) {
  const int32_t places = roadmap->num_vertices();
  Tautener tautener(space, kReach * eta, *roadmap);
  for (int32_t v = 0; v < places; ++v) tautener.Connect(v);
  const size_t most = kBendsPerPlace * static_cast<size_t>(places);
  for (const Vector3d& bend : FindBends(space, eta, most)) tautener.AddBend(bend);
  *roadmap = tautener.Finish();
  roadmap->num_bends = roadmap->num_vertices() - places;
  roadmap->taut = true;
}

}  // namespace cairn::planner
