#include "planner/builders/bends.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "planner/builders/point_tree.h"

namespace cairn::planner {
namespace {

constexpr double kQuarter = 0.5 * std::numbers::pi;
constexpr int kLegs = 2;  // of a quarter turn

// Offers points around every obstacle's convex edges; which of them are free is not asked here.
template <typename Offer>
class Edges {
 public:
  Edges(const World& world, double radius, double spacing, const Offer& offer)
      : world_(world), radius_(radius), spacing_(spacing), offer_(offer) {}

  void Around(const Box& box) const {
    for (int axis = world_.dimension == 2 ? 2 : 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (int corner = 0; corner < 4; ++corner) {
        const double side_u = corner % 2 == 0 ? -1 : 1, side_v = corner < 2 ? -1 : 1;
        Vector3d edge = Vector3d::Zero();
        edge[u] = side_u < 0 ? box.min[u] : box.max[u];
        edge[v] = side_v < 0 ? box.min[v] : box.max[v];
        ForEachAlong(box.min[axis], box.max[axis], axis, [&](double at) {
          edge[axis] = at;
          Turn(edge, side_u * Vector3d::Unit(u), side_v * Vector3d::Unit(v), radius_, kLegs);
        });
      }
    }
  }

  void Around(const Cylinder& c) const {
    const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
    const double outside = c.radius + radius_;
    const int legs = std::max(kLegs, static_cast<int>(std::ceil(kQuarter * outside / spacing_)));
    ForEachAlong(c.base.z(), c.base.z() + c.height, 2, [&](double at) {
      const Vector3d center(c.base.x(), c.base.y(), at);
      for (const double side : {-1, 1}) {
        Turn(center, side * x, side * y, outside, legs);
        Turn(center, side * y, -side * x, outside, legs);
      }
    });
    if (world_.dimension == 2) return;
    for (int i = 0; i < 4 * legs; ++i) {
      const Vector3d out = std::cos(i * kQuarter / legs) * x + std::sin(i * kQuarter / legs) * y;
      Turn(c.base + c.radius * out, out, -z, radius_, kLegs);
      Turn(c.base + c.radius * out + c.height * z, out, z, radius_, kLegs);
    }
  }

 private:
  // The middles of pieces of at most the spacing; z = 0 in the plane.
  template <typename Visit>
  void ForEachAlong(double low, double high, int axis, const Visit& visit) const {
    if (world_.dimension == 2) return visit(0.0);
    low = std::max(low, world_.bounds.min[axis]);
    high = std::min(high, world_.bounds.max[axis]);
    const int pieces = static_cast<int>(std::ceil((high - low) / spacing_));
    for (int i = 0; i < pieces; ++i) visit(low + (i + 0.5) * (high - low) / pieces);
  }

  // From direction u to direction v around the centre: where the tangents of an arc in equal parts meet.
  void Turn(const Vector3d& center, const Vector3d& u, const Vector3d& v, double radius, int legs) const {
    const double step = kQuarter / legs, outside = radius / std::cos(0.5 * step);
    for (int i = 0; i < legs; ++i) {
      const double angle = (i + 0.5) * step;
      offer_(Vector3d(center + outside * (std::cos(angle) * u + std::sin(angle) * v)));
    }
  }

  const World& world_;
  double radius_, spacing_;  // [m]
  const Offer& offer_;
};

// What rounding to float may take from a distance, and a little of the radius that ways along walls need not touch.
double Slack(const World& world, double radius) {
  const double farthest = std::max(world.bounds.min.cwiseAbs().maxCoeff(), world.bounds.max.cwiseAbs().maxCoeff());
  return 1e-5 * radius + 4 * std::numeric_limits<float>::epsilon() * farthest;
}

std::vector<Vector3d> FreeBends(const FreeSpace& space, double spacing) {
  const World& world = space.world();
  std::vector<Vector3d> bends;
  const auto offer = [&](const Vector3d& exact) {
    const Vector3d p = RoundToFloat(exact, world.dimension);
    if (space.Contains(p)) bends.push_back(p);
  };
  const double radius = space.checker().radius();
  const Edges edges(world, radius + Slack(world, radius), spacing, offer);
  for (const Box& box : world.boxes) edges.Around(box);
  for (const Cylinder& cylinder : world.cylinders) edges.Around(cylinder);
  return bends;
}

std::vector<Vector3d> Thin(const std::vector<Vector3d>& points, int dimension, double spacing) {
  PointTree kept(dimension);
  std::vector<int32_t> near;
  std::vector<Vector3d> thinned;
  for (const Vector3d& p : points) {
    kept.Within(p, spacing, near);
    if (!near.empty()) continue;
    kept.Add(p);
    thinned.push_back(p);
  }
  return thinned;
}

}  // namespace

std::vector<Vector3d> FindBends(const FreeSpace& space, double eta, size_t max_count) {
  std::vector<Vector3d> bends = FreeBends(space, 0.5 * eta);
  RandomStream random(1, RandomPurpose::kPlanner, 4);  // shuffled, which keeps trees of points flat
  for (size_t i = bends.size(); i > 1; --i) std::swap(bends[i - 1], bends[random.Below(i)]);
  double spacing = eta / 5;
  for (bends = Thin(bends, space.world().dimension, spacing); bends.size() > max_count; spacing *= 2) {
    bends = Thin(bends, space.world().dimension, 2 * spacing);
  }
  return bends;
}

}  // namespace cairn::planner
