#pragma once

#include "common/roadmap/roadmap.h"

namespace cairn::planner {

/// Calls visit(v, u), v < u, for the edges that pictures show: the graph as it was built, without what makes its costs
/// taut. Those are not edges to bends, nor longer than `longest` [m] (0: of any length).
template <typename Visit>
void ForEachShownEdge(const Roadmap& roadmap, double longest, const Visit& visit) {
  for (int v = 0; v < roadmap.num_places(); ++v) {
    for (int e = roadmap.offsets[v]; e < roadmap.offsets[v + 1]; ++e) {
      const int u = roadmap.neighbors[e];
      if (u > v && u < roadmap.num_places() && (longest == 0 || roadmap.lengths[e] <= longest)) visit(v, u);
    }
  }
}

}  // namespace cairn::planner
