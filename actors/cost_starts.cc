#include "actors/cost_starts.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"

namespace cairn::actors {

CostStarts::CostStarts(const RoadmapLookup& lookup) : dimension_(lookup.dimension()), r_ball_(lookup.r_ball()) {
  for (int v = 0; v < lookup.num_places(); ++v) {
    const float cost = lookup.table().cost[v];
    if (std::isfinite(cost)) vertices_.push_back({cost, lookup.position(v)});
  }
  std::stable_sort(vertices_.begin(), vertices_.end(),
                   [](const Vertex& a, const Vertex& b) { return a.cost < b.cost; });
}

// Among the vertices within r_ball of the drawn cost each is as likely; where there is none, the next one up.
Vector3d CostStarts::Draw(RandomStream& random) const {
  CAIRN_CHECK(!empty());
  const double cost = random.Uniform(0, vertices_.back().cost);
  const auto below = [](const Vertex& vertex, double c) { return vertex.cost < c; };
  const auto first = std::lower_bound(vertices_.begin(), vertices_.end(), cost - r_ball_, below);
  const auto last = std::lower_bound(first, vertices_.end(), cost + r_ball_, below);
  const auto count = static_cast<uint32_t>(std::max<std::ptrdiff_t>(1, last - first));
  Vector3d p = (first + random.Below(count))->position;
  for (int k = 0; k < dimension_; ++k) p[k] += random.Uniform(-r_ball_, r_ball_);
  return p;
}

}  // namespace cairn::actors
