#pragma once

#include <vector>

#include "common/roadmap/roadmap.h"

namespace cairn::planner {

/// Cost to the nearest source [m] and the next vertex towards it, per vertex; kUnreachable and −1 where there is none.
struct ShortestPaths {
  std::vector<float> cost;
  std::vector<int32_t> next_vertex;
};

/// Where ways end: a vertex with the cost that is left from it [m] and the vertex it is left towards, −1 for none.
struct Source {
  int32_t vertex = 0;
  float cost = 0;
  int32_t next_vertex = -1;
};

/// Dijkstra from several sources at once; of one vertex named twice the cheaper, then the first holds. Ties are broken
/// by vertex number, so the result depends on the graph alone.
ShortestPaths ComputeShortestPaths(const Roadmap& roadmap, const std::vector<Source>& sources);

/// The same from vertices at which the cost is 0.
ShortestPaths ComputeShortestPaths(const Roadmap& roadmap, const std::vector<int32_t>& sources);

/// Share of the straight way from a to b ∈ [0, 1] that lies before it enters the box, over `dimension` axes; b inside.
double ShareOutside(const Box& box, int dimension, const Vector3d& a, const Vector3d& b);

}  // namespace cairn::planner
