#include "planner/path.h"

#include <cmath>
#include <tuple>

#include "planner/cost_to_go.h"

namespace cairn::planner {

Path PathFrom(const Roadmap& roadmap, const CostTable& table, int vertex) {
  Path path;
  if (!std::isfinite(table.cost[vertex])) return path;
  path.length = table.cost[vertex];
  for (int v = vertex; v >= 0; v = table.next_vertex[v]) path.points.push_back(roadmap.position(v));
  if (roadmap.taut && path.points.size() > 1) {  // ends where it enters the goal region
    const Vector3d before = path.points[path.points.size() - 2];
    Vector3d& last = path.points.back();
    last = before + ShareOutside(table.goal, roadmap.dimension, before, last) * (last - before);
  }
  return path;
}

Path OptimalPath(const World& world, const Roadmap& roadmap, const CostTable& table) {
  int best = -1;
  std::tuple<bool, double> best_rank;  // outside the region, distance to its centre
  for (int v = 0; v < roadmap.num_vertices(); ++v) {
    if (!std::isfinite(table.cost[v])) continue;
    const Vector3d p = roadmap.position(v);
    const std::tuple<bool, double> rank{!world.Contains(world.start, p), (p - world.start.center()).norm()};
    if (best >= 0 && rank >= best_rank) continue;
    best = v;
    best_rank = rank;
  }
  return best < 0 ? Path{} : PathFrom(roadmap, table, best);
}

}  // namespace cairn::planner
