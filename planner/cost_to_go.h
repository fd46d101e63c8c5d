#pragma once

#include <vector>

#include "common/roadmap/roadmap.h"

namespace cairn::planner {

/// Cost to the nearest source [m] and the next vertex towards it, per vertex; kUnreachable and −1 where there is none.
struct ShortestPaths {
  std::vector<float> cost;
  std::vector<int32_t> next_vertex;
};

/// Dijkstra from several sources at once. Ties are broken by vertex number, so the result depends on the graph alone.
ShortestPaths ComputeShortestPaths(const Roadmap& roadmap, const std::vector<int32_t>& sources);

}  // namespace cairn::planner
