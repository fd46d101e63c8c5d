#pragma once

#include <vector>

#include "common/core/random.h"
#include "common/roadmap/roadmap_lookup.h"

namespace cairn::actors {

/// Draws points whose cost-to-go is spread evenly from the goal to the farthest corner (environment.start =
/// COST_TO_GO), where uniform ones would nearly all be far from the goal. Immutable; any thread.
class CostStarts {
 public:
  /// Keeps a copy of the reachable vertices alone; there may be none, then Draw must not be called.
  explicit CostStarts(const RoadmapLookup& lookup);

  bool empty() const { return vertices_.empty(); }

  /// A point within r_ball, along each axis, of a vertex whose cost is about a uniformly drawn one; not checked to be
  /// free. Takes 2 + dimension numbers from the stream, z of a plane world is 0.
  Vector3d Draw(RandomStream& random) const;

 private:
  struct Vertex {
    float cost;
    Vector3d position;
  };
  int dimension_;
  double r_ball_;
  std::vector<Vertex> vertices_;  // by rising cost, then number
};

}  // namespace cairn::actors
