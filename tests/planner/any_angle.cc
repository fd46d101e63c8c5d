#include "tests/planner/any_angle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>

#include "common/world/signed_distance.h"

namespace cairn::planner {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kTolerance = 1e-6;  // [m]
constexpr double kQuarter = 0.5 * std::numbers::pi;
constexpr int kLegs = 8;  // of a quarter turn

// Whether the obstacle's distance falls below `least` on the way from a to b.
template <typename Obstacle>
bool ComesNearer(const Obstacle& obstacle, int dimension, const Vector3d& a, const Vector3d& b, double least) {
  const auto distance = [&](double t) { return std::max(0.0, SignedDistance(obstacle, a + t * (b - a), dimension)); };
  const double golden = 0.5 * (std::sqrt(5.0) - 1), length = (b - a).norm();
  double low = 0, high = 1, left = 1 - golden, right = golden;
  double at_left = distance(left), at_right = distance(right);
  if (distance(0) < least || distance(1) < least) return true;
  while (true) {
    const double smaller = std::min(at_left, at_right);
    if (smaller < least) return true;
    if ((high - low) * length < kTolerance || smaller - (high - low) * length > least) return false;
    if (at_left < at_right) {
      high = right;
      right = left;
      at_right = at_left;
      at_left = distance(left = high - golden * (high - low));
    } else {
      low = left;
      left = right;
      at_left = at_right;
      at_right = distance(right = low + golden * (high - low));
    }
  }
}

Vector3d Nearest(const Box& box, const Vector3d& p) { return p.cwiseMax(box.min).cwiseMin(box.max); }

using Item = std::pair<double, int32_t>;  // cost, node
using Queue = std::priority_queue<Item, std::vector<Item>, std::greater<>>;

}  // namespace

bool StraightWays::Free(const Vector3d& p) const { return SignedDistance(world_, p) >= radius_ - kTolerance; }

bool StraightWays::Clear(const Vector3d& a, const Vector3d& b) const {
  const double least = radius_ - kTolerance;
  const int dimension = world_.dimension;
  for (const Vector3d& p : {a, b}) {  // the bounds are convex
    if (-SignedDistance(world_.bounds, p, dimension) < least) return false;
  }
  const Vector3d low = a.cwiseMin(b).array() - least, high = a.cwiseMax(b).array() + least;
  const auto apart = [&](const Vector3d& min, const Vector3d& max) {
    for (int k = 0; k < dimension; ++k) {
      if (min[k] >= high[k] || max[k] <= low[k]) return true;
    }
    return false;
  };
  for (const Box& box : world_.boxes) {
    if (!apart(box.min, box.max) && ComesNearer(box, dimension, a, b, least)) return false;
  }
  for (const Cylinder& c : world_.cylinders) {
    const Vector3d side(c.radius, c.radius, 0);
    if (apart(c.base - side, c.base + side + Vector3d(0, 0, c.height))) continue;
    if (ComesNearer(c, dimension, a, b, least)) return false;
  }
  return true;
}

double StraightWays::ToGoal(const Vector3d& p) const {
  Vector3d nearest = Nearest(world_.goal, p);
  if (world_.dimension == 2) nearest.z() = p.z();
  return Clear(p, nearest) ? (p - nearest).norm() : kInfinite;
}

PlaneTruth::PlaneTruth(const World& world, double radius) : ways_(world, radius) {
  for (const Box& box : world.boxes) {
    for (int corner = 0; corner < 4; ++corner) {  // counter-clockwise from the upper right one
      const bool right = corner == 0 || corner == 3, upper = corner < 2;
      const Vector3d center(right ? box.max.x() : box.min.x(), upper ? box.max.y() : box.min.y(), 0);
      AddArc(center, radius, kQuarter * corner, kQuarter * (corner + 1));
    }
  }
  for (const Cylinder& c : world.cylinders) {
    AddArc(Vector3d(c.base.x(), c.base.y(), 0), c.radius + radius, 0, 4 * kQuarter);
  }
  cost_.assign(bends_.size(), kInfinite);
  std::vector<char> settled(bends_.size(), 0);
  Queue queue;
  for (size_t i = 0; i < bends_.size(); ++i) queue.emplace(cost_[i] = ways_.ToGoal(bends_[i]), i);
  while (!queue.empty()) {
    const auto [cost, i] = queue.top();
    queue.pop();
    if (settled[i] || cost == kInfinite) continue;
    settled[i] = 1;
    for (size_t k = 0; k < bends_.size(); ++k) {
      const double through = cost + (bends_[k] - bends_[i]).norm();
      if (through < cost_[k] && ways_.Clear(bends_[i], bends_[k])) queue.emplace(cost_[k] = through, k);
    }
  }
}

// Where neighbouring tangents of the arc meet, so that the legs between them just keep clear of it.
void PlaneTruth::AddArc(const Vector3d& center, double radius, double from, double to) {
  const int legs = static_cast<int>(std::lround((to - from) / kQuarter * kLegs));
  const double step = (to - from) / legs, outside = radius / std::cos(0.5 * step);
  for (int i = 0; i < legs; ++i) {
    const double angle = from + (i + 0.5) * step;
    const Vector3d p = center + outside * Vector3d(std::cos(angle), std::sin(angle), 0);
    if (ways_.Free(p)) bends_.push_back(p);
  }
}

double PlaneTruth::Length(const Vector3d& p) const {
  double best = ways_.ToGoal(p);
  std::vector<Item> through;
  for (size_t i = 0; i < bends_.size(); ++i) through.emplace_back((bends_[i] - p).norm() + cost_[i], i);
  std::sort(through.begin(), through.end());
  for (const auto& [length, i] : through) {
    if (length >= best) break;
    if (ways_.Clear(p, bends_[i])) best = length;
  }
  return best;
}

SpaceTruth::SpaceTruth(const World& world, double radius, double resolution)
    : ways_(world, radius),
      resolution_(resolution),
      nodes_((world.bounds.size() / resolution).array().floor().cast<int>() + 1) {
  const auto count = static_cast<size_t>(nodes_.prod());
  free_.resize(count);
  for (size_t i = 0; i < count; ++i) free_[i] = ways_.Free(Position(static_cast<int32_t>(i)));
  cost_.assign(count, kInfinite);
  parent_.assign(count, kNone);
  Search();
}

size_t SpaceTruth::Index(const Eigen::Vector3i& node) const {
  return (static_cast<size_t>(node.z()) * nodes_.y() + node.y()) * nodes_.x() + node.x();
}

Vector3d SpaceTruth::Position(int32_t node) const {
  const Eigen::Vector3i index(node % nodes_.x(), node / nodes_.x() % nodes_.y(), node / nodes_.x() / nodes_.y());
  return ways_.world().bounds.min + resolution_ * index.cast<double>();
}

template <typename Visit>
void SpaceTruth::ForEachNear(const Eigen::Vector3i& node, int reach, const Visit& visit) const {
  const Eigen::Vector3i low = (node.array() - reach).max(0), high = (node.array() + reach).min(nodes_.array() - 1);
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const size_t other = Index(Eigen::Vector3i(x, y, z));
        if (free_[other]) visit(static_cast<int32_t>(other));
      }
    }
  }
}

void SpaceTruth::Search() {
  std::vector<char> settled(cost_.size(), 0);
  Queue queue;
  const auto offer = [&](int32_t node, double cost, int32_t parent) {
    cost_[node] = cost;
    parent_[node] = parent;
    queue.emplace(cost, node);
  };
  for (size_t i = 0; i < cost_.size(); ++i) {
    const double straight = free_[i] ? ways_.ToGoal(Position(static_cast<int32_t>(i))) : kInfinite;
    if (straight < kInfinite) offer(static_cast<int32_t>(i), straight, kGoal);
  }
  while (!queue.empty()) {
    const int32_t i = queue.top().second;
    queue.pop();
    if (settled[i]) continue;
    settled[i] = 1;
    const Eigen::Vector3i node(i % nodes_.x(), i / nodes_.x() % nodes_.y(), i / nodes_.x() / nodes_.y());
    ForEachNear(node, 1, [&](int32_t k) {
      if (settled[k] || parent_[k] == kGoal) return;
      const Vector3d p = Position(k);
      if (parent_[i] >= 0) {
        const double through = cost_[parent_[i]] + (p - Position(parent_[i])).norm();
        if (through >= cost_[k]) return;
        if (ways_.Clear(Position(parent_[i]), p)) return offer(k, through, parent_[i]);
      }
      const double through = cost_[i] + (p - Position(i)).norm();
      if (through < cost_[k] && ways_.Clear(Position(i), p)) offer(k, through, i);
    });
  }
}

double SpaceTruth::Measure(const std::vector<Vector3d>& way) const {
  double length = 0;
  for (size_t i = 1; i < way.size(); ++i) length += (way[i] - way[i - 1]).norm();
  return length;
}

// Moves each bend to the best of 26 places around it, by smaller and smaller steps; the last point is the nearest of
// the goal region. A bend that can be left out is.
void SpaceTruth::Tighten(std::vector<Vector3d>* way) const {
  const auto length_at = [&](size_t i, const Vector3d& p) {
    const bool last = i + 2 == way->size();
    const Vector3d next = last ? Nearest(ways_.world().goal, p) : (*way)[i + 1];
    return (p - (*way)[i - 1]).norm() + (next - p).norm();
  };
  const auto clear_at = [&](size_t i, const Vector3d& p) {
    const bool last = i + 2 == way->size();
    const Vector3d next = last ? Nearest(ways_.world().goal, p) : (*way)[i + 1];
    return ways_.Clear((*way)[i - 1], p) && ways_.Clear(p, next);
  };
  for (double step = resolution_; step > resolution_ / 40; step /= 2) {
    bool moved = true;
    for (int round = 0; moved && round < 50; ++round) {
      moved = false;
      for (size_t i = 1; i + 1 < way->size(); ++i) {
        if (ways_.Clear((*way)[i - 1], (*way)[i + 1])) {
          way->erase(way->begin() + static_cast<ptrdiff_t>(i--));
          continue;
        }
        Vector3d best = (*way)[i];
        double best_length = length_at(i, best) - 1e-9;
        for (int k = 0; k < 27; ++k) {
          const Vector3d p = (*way)[i] + step * Vector3d(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
          const double length = length_at(i, p);
          if (length >= best_length || !clear_at(i, p)) continue;
          best = p;
          best_length = length;
        }
        moved |= best != (*way)[i];
        (*way)[i] = best;
        if (i + 2 == way->size()) way->back() = Nearest(ways_.world().goal, best);
      }
    }
  }
}

double SpaceTruth::Length(const Vector3d& p) const {
  if (const double straight = ways_.ToGoal(p); straight < kInfinite) return straight;
  const Eigen::Vector3i node = ((p - ways_.world().bounds.min) / resolution_).array().round().cast<int>();
  std::vector<Item> through;
  ForEachNear(node, 3, [&](int32_t i) { through.emplace_back((Position(i) - p).norm() + cost_[i], i); });
  std::sort(through.begin(), through.end());
  for (const auto& [length, first] : through) {
    if (length == kInfinite || !ways_.Clear(p, Position(first))) continue;
    std::vector<Vector3d> way{p};
    for (int32_t i = first; i >= 0; i = parent_[i]) way.push_back(Position(i));
    way.push_back(Nearest(ways_.world().goal, way.back()));
    Tighten(&way);
    return Measure(way);
  }
  return kInfinite;
}

}  // namespace cairn::planner
