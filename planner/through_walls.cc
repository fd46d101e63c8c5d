#include "planner/through_walls.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "common/core/check.h"
#include "common/core/random.h"
#include "planner/builders/point_tree.h"

namespace cairn::planner {
namespace {

constexpr int kSamples = 20000;
constexpr int kDrawsPerSample = 1000;
// Vertices in sight are looked for this far, in r_ball: those within r_ball may all stand behind the wall.
constexpr double kSightBalls = 3;

// Vertices in random order, as the tree of points wants them: those of a lattice come sorted.
std::vector<int32_t> Shuffled(int count) {
  std::vector<int32_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  RandomStream random(0, RandomPurpose::kPlanner, 4);
  for (int i = count - 1; i > 0; --i) std::swap(order[i], order[random.Below(static_cast<uint32_t>(i) + 1)]);
  return order;
}

class Sight {
 public:
  Sight(const DistanceField& field, const Roadmap& roadmap, const CostTable& table, double r_ball)
      : field_(field), r_ball_(r_ball), tree_(roadmap.dimension) {
    for (const int32_t v : Shuffled(roadmap.num_vertices())) {
      tree_.Add(roadmap.position(v));
      cost_.push_back(table.cost[v]);
      is_bend_.push_back(v >= roadmap.num_places());
    }
  }

  // How much cheaper than anything in sight the cheapest vertex within r_ball is [m]; 0 when it is in sight.
  double Jump(const Vector3d& p) {
    tree_.Within(p, r_ball_, found_);
    int cheapest = -1;
    for (const int32_t v : found_) {
      if (is_bend_[v]) continue;  // D(s) does not see it
      if (cheapest < 0 || cost_[v] < cost_[cheapest]) cheapest = v;
    }
    if (cheapest < 0 || !std::isfinite(cost_[cheapest]) || Sees(p, cheapest)) return 0;
    double in_sight = std::numeric_limits<double>::infinity();
    tree_.Within(p, kSightBalls * r_ball_, found_);
    for (const int32_t v : found_) {
      if (cost_[v] < in_sight && Sees(p, v)) in_sight = cost_[v];
    }
    return in_sight - cost_[cheapest];
  }

 private:
  // Walls of one node's width show as a distance of 0 only, give or take the interpolation.
  bool Sees(const Vector3d& p, int vertex) const {
    return field_.SegmentClear(p, tree_.point(vertex), field_.interpolation_error());
  }

  const DistanceField& field_;
  double r_ball_;
  PointTree tree_;
  std::vector<float> cost_;     // by number in the tree
  std::vector<char> is_bend_;   // by number in the tree
  std::vector<int32_t> found_;  // scratch
};

}  // namespace

void CheckCostsBehindWalls(const World& world, const DistanceField& field, const Roadmap& roadmap,
                           const CostTable& table, const PlannerConfig& config, double inscribed_radius) {
  if (NoWallIsTooThin(config, inscribed_radius)) return;
  const double certain = config.radius + inscribed_radius;
  Sight sight(field, roadmap, table, config.r_ball());
  RandomStream random(config.seed, RandomPurpose::kPlanner, 3);
  for (int draw = 0, samples = 0; samples < kSamples && draw < kSamples * kDrawsPerSample; ++draw) {
    Vector3d p = Vector3d::Zero();
    for (int k = 0; k < world.dimension; ++k) p[k] = random.Uniform(world.bounds.min[k], world.bounds.max[k]);
    if (field.Distance(p) < inscribed_radius) continue;
    ++samples;
    const double jump = sight.Jump(p);
    if (jump <= 2 * config.r_ball()) continue;
    ThrowUsageError(
        "planner.eta = {} m: at ({:.4g}, {:.4g}) the cheapest vertex within r_ball = eta / 2 stands behind a wall, "
        "{:.3g} m cheaper than what is in sight; an eta below 2 (planner.radius + inscribed radius) = {:.4g} m is "
        "certain to pass",
        config.eta, p.x(), p.y(), jump, 2 * certain);
  }
}

}  // namespace cairn::planner
