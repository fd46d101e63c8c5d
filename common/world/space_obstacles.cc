#include "common/world/space_obstacles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/check.h"
#include "common/world/signed_distance.h"

namespace cairn {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMaxCells = 4194304;

// As for the plane: cells near the mean distance between obstacles.
double ChooseCell(const World& world, double reach) {
  const double volume = world.bounds.size().prod();
  const double obstacles = static_cast<double>(world.boxes.size() + world.cylinders.size() + 1);
  return std::max({0.7 * std::cbrt(volume / obstacles), 0.25 * reach, std::cbrt(volume / kMaxCells)});
}

Box Enclosing(const Cylinder& c) {
  const Vector3d side(c.radius, c.radius, 0);
  return {c.base - side, c.base + side + Vector3d(0, 0, c.height)};
}

}  // namespace

struct SpaceObstacles::Ray {
  Vector3d p, direction, inverse;
};

SpaceObstacles::SpaceObstacles(const World& world, double reach)
    : boxes_(world.boxes),
      cylinders_(world.cylinders),
      bounds_(world.bounds),
      reach_(reach),
      cell_(ChooseCell(world, reach)),
      inverse_cell_(1 / cell_) {
  CAIRN_CHECK(world.dimension == 3, "space obstacles are for worlds in space");
  cells_ = ((bounds_.size() * inverse_cell_).array().floor() + 1).cast<int>();
  near_ = Fill(reach_);
  touching_ = Fill(0);
}

int SpaceObstacles::CellIndex(int axis, double coordinate) const {
  const double cell = std::floor((coordinate - bounds_.min[axis]) * inverse_cell_);
  return static_cast<int>(std::clamp(cell, 0.0, static_cast<double>(cells_[axis] - 1)));
}

// Lists for each cell the obstacles whose box comes within `margin` of it (Chebyshev: a superset), cells widened by a
// millionth against rounding. Two passes: count, then place.
SpaceObstacles::Buckets SpaceObstacles::Fill(double margin) const {
  const Vector3d slack = Vector3d::Constant(margin + 1e-6 * cell_);
  const auto num_boxes = boxes_.size();
  const auto for_each_cell = [&](const auto& visit) {
    for (size_t i = 0; i < num_boxes + cylinders_.size(); ++i) {
      const Box box = i < num_boxes ? boxes_[i] : Enclosing(cylinders_[i - num_boxes]);
      Eigen::Vector3i low, high, cell;
      for (int k = 0; k < 3; ++k) {
        low[k] = CellIndex(k, box.min[k] - slack[k]);
        high[k] = CellIndex(k, box.max[k] + slack[k]);
      }
      for (cell.z() = low.z(); cell.z() <= high.z(); ++cell.z()) {
        for (cell.y() = low.y(); cell.y() <= high.y(); ++cell.y()) {
          for (cell.x() = low.x(); cell.x() <= high.x(); ++cell.x()) visit(CellOf(cell), static_cast<int32_t>(i));
        }
      }
    }
  };
  Buckets buckets;
  buckets.offsets.assign(static_cast<size_t>(cells_.prod()) + 1, 0);
  for_each_cell([&](int cell, int32_t) { ++buckets.offsets[static_cast<size_t>(cell) + 1]; });
  for (size_t i = 1; i < buckets.offsets.size(); ++i) buckets.offsets[i] += buckets.offsets[i - 1];
  buckets.items.resize(static_cast<size_t>(buckets.offsets.back()));
  std::vector<int32_t> next(buckets.offsets.begin(), buckets.offsets.end() - 1);
  for_each_cell(
      [&](int cell, int32_t i) { buckets.items[static_cast<size_t>(next[static_cast<size_t>(cell)]++)] = i; });
  return buckets;
}

bool SpaceObstacles::InBounds(const Vector3d& p, double margin) const {
  for (int k = 0; k < 3; ++k) {
    if (!(p[k] - margin >= bounds_.min[k] && p[k] + margin <= bounds_.max[k])) return false;
  }
  return true;
}

bool SpaceObstacles::Overlaps(const Vector3d& center, double radius) const {
  CAIRN_DCHECK(radius <= reach_, "sphere larger than the reach");
  if (!InBounds(center, radius)) return true;
  const int cell = CellOf({CellIndex(0, center.x()), CellIndex(1, center.y()), CellIndex(2, center.z())});
  const double squared_radius = radius * radius;
  for (int k = near_.offsets[cell]; k < near_.offsets[cell + 1]; ++k) {
    const auto item = static_cast<size_t>(near_.items[k]);
    if (item < boxes_.size()) {
      double squared = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double gap =
            std::max({boxes_[item].min[axis] - center[axis], center[axis] - boxes_[item].max[axis], 0.0});
        squared += gap * gap;
      }
      if (squared <= squared_radius) return true;
    } else if (SignedDistance(cylinders_[item - boxes_.size()], center, 3) <= radius) {
      return true;
    }
  }
  return false;
}

// Where the ray enters the obstacle, 0 when it starts inside, infinity when it misses.
double SpaceObstacles::Hit(int obstacle, const Ray& ray) const {
  const auto item = static_cast<size_t>(obstacle);
  double enter = -kInfinity, leave = kInfinity;
  const auto clip = [&](int axis, double low, double high) {
    const double a = (low - ray.p[axis]) * ray.inverse[axis], b = (high - ray.p[axis]) * ray.inverse[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  };
  if (item < boxes_.size()) {
    for (int axis = 0; axis < 3; ++axis) clip(axis, boxes_[item].min[axis], boxes_[item].max[axis]);
  } else {  // between the roots of |level part of p + t d − axis|² = radius², and between the faces
    const Cylinder& c = cylinders_[item - boxes_.size()];
    clip(2, c.base.z(), c.base.z() + c.height);
    const double px = ray.p.x() - c.base.x(), py = ray.p.y() - c.base.y();
    const double dx = ray.direction.x(), dy = ray.direction.y();
    const double a = dx * dx + dy * dy, b = px * dx + py * dy, inside = px * px + py * py - c.radius * c.radius;
    if (a < 1e-24) {
      if (inside > 0) return kInfinity;
    } else {
      const double discriminant = b * b - a * inside;
      if (discriminant < 0) return kInfinity;
      const double root = std::sqrt(discriminant);
      enter = std::max(enter, (-b - root) / a);
      leave = std::min(leave, (-b + root) / a);
    }
  }
  return leave >= 0 && enter <= leave ? std::max(enter, 0.0) : kInfinity;
}

double SpaceObstacles::CastRay(const Vector3d& p, const Vector3d& direction, double max_range) const {
  if (!InBounds(p, 0)) return 0;
  Ray ray{p, direction, Vector3d::Zero()};
  Eigen::Vector3i cell, step;
  Vector3d next, delta;  // ray length to the next cell's border, and between borders, per axis
  double best = max_range;
  for (int k = 0; k < 3; ++k) {
    // A zero component becomes tiny: its slab then spans all of the ray, and 0 · ∞ cannot make a NaN.
    ray.inverse[k] = 1 / (std::abs(direction[k]) < 1e-300 ? 1e-300 : direction[k]);
    step[k] = ray.inverse[k] > 0 ? 1 : -1;
    best = std::min(best, ((step[k] > 0 ? bounds_.max[k] : bounds_.min[k]) - p[k]) * ray.inverse[k]);
    cell[k] = CellIndex(k, p[k]);
    next[k] = (bounds_.min[k] + (cell[k] + (step[k] > 0)) * cell_ - p[k]) * ray.inverse[k];
    delta[k] = std::abs(cell_ * ray.inverse[k]);
  }
  while (true) {
    const int here = CellOf(cell);
    for (int k = touching_.offsets[here]; k < touching_.offsets[here + 1]; ++k) {
      best = std::min(best, Hit(touching_.items[k], ray));
    }
    const int axis = next.x() < next.y() ? (next.x() < next.z() ? 0 : 2) : (next.y() < next.z() ? 1 : 2);
    if (best <= next[axis]) return best;
    cell[axis] += step[axis];
    if (cell[axis] < 0 || cell[axis] >= cells_[axis]) return best;
    next[axis] += delta[axis];
  }
}

}  // namespace cairn
