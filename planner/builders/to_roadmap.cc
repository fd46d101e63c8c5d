#include "planner/builders/to_roadmap.h"

#include <algorithm>

namespace cairn::planner {

Roadmap ToRoadmap(int dimension, const PointTree& vertices, const std::vector<std::vector<int32_t>>& neighbors) {
  Roadmap roadmap;
  roadmap.dimension = dimension;
  roadmap.offsets.push_back(0);
  for (int v = 0; v < vertices.size(); ++v) {
    const Vector3d& p = vertices.point(v);
    for (int k = 0; k < dimension; ++k) roadmap.positions.push_back(static_cast<float>(p[k]));
    std::vector<int32_t> sorted = neighbors[v];
    std::sort(sorted.begin(), sorted.end());
    for (const int32_t other : sorted) {
      roadmap.neighbors.push_back(other);
      roadmap.lengths.push_back(static_cast<float>((vertices.point(other) - p).norm()));
    }
    roadmap.offsets.push_back(static_cast<int32_t>(roadmap.neighbors.size()));
  }
  return roadmap;
}

}  // namespace cairn::planner
