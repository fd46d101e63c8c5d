#include "common/world/reachability.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/core/check.h"

namespace cairn {
namespace {

// Calls visit(p) on a lattice of the region no coarser than `step` and with at least 17 points a side.
template <typename Visit>
void ForEachPoint(const Box& region, int dimension, double step, const Visit& visit) {
  int counts[3] = {1, 1, 1};
  for (int k = 0; k < dimension; ++k) {
    counts[k] = std::max(17, static_cast<int>(std::ceil(region.size()[k] / step)) + 1);
  }
  const auto coordinate = [&](int k, int i) {
    return counts[k] == 1 ? 0.0 : region.min[k] + region.size()[k] * i / (counts[k] - 1);
  };
  for (int z = 0; z < counts[2]; ++z) {
    for (int y = 0; y < counts[1]; ++y) {
      for (int x = 0; x < counts[0]; ++x) visit(Vector3d(coordinate(0, x), coordinate(1, y), coordinate(2, z)));
    }
  }
}

// Of a map the obstacles are many and the field knows them.
World WithoutObstacles(const World& world) {
  World outline;
  outline.dimension = world.dimension;
  outline.bounds = world.bounds;
  outline.start = world.start;
  outline.goal = world.goal;
  return outline;
}

std::string Describe(const Box& box, int dimension) {
  std::string text;
  for (int k = 0; k < dimension; ++k) {
    text += fmt::format("{}[{:.4g}, {:.4g}]", k == 0 ? "" : " × ", box.min[k], box.max[k]);
  }
  return text + " m";
}

}  // namespace

Reachability::Reachability(const World& world, const DistanceField& field, double radius)
    : world_(WithoutObstacles(world)), field_(field), radius_(radius), step_(field.resolution()), nodes_(1, 1, 1) {
  for (int k = 0; k < world.dimension; ++k) {
    nodes_[k] = std::max(2, static_cast<int>(std::ceil(world.bounds.size()[k] / step_ - 1e-9)) + 1);
  }
  first_ = nodes_;
  last_.setZero();
  reached_.assign(static_cast<size_t>(nodes_.x()) * nodes_.y() * nodes_.z(), 0);
  std::vector<Eigen::Vector3i> front;
  double most_room = -std::numeric_limits<double>::infinity();
  ForEachPoint(world_.goal, world_.dimension, step_, [&](const Vector3d& p) {
    const double room = field_.Distance(p);
    if (room > most_room) {
      most_room = room;
      goal_point_ = p;
    }
    if (room >= radius_) Seed(p, front);
  });
  if (!(most_room >= radius_)) ThrowNoRoom(most_room);
  Flood(std::move(front));
  ForEachFreeNode([&](const Eigen::Vector3i&) { ++num_free_; });
}

template <typename Visitor>
void Reachability::ForEachFreeNode(const Visitor& visitor) const {
  Eigen::Vector3i node;
  for (node.z() = 0; node.z() < nodes_.z(); ++node.z()) {
    for (node.y() = 0; node.y() < nodes_.y(); ++node.y()) {
      for (node.x() = 0; node.x() < nodes_.x(); ++node.x()) {
        if (field_.Distance(NodePosition(node)) >= radius_) visitor(node);
      }
    }
  }
}

void Reachability::ThrowNoRoom(double most_room) const {
  const Vector3d center = world_.goal.center();
  double nearest = std::numeric_limits<double>::infinity();
  std::string cure = "; no point of the world is";
  ForEachFreeNode([&](const Eigen::Vector3i& node) {
    const Vector3d p = NodePosition(node);
    const double distance = (p - center).norm();
    if (distance >= nearest) return;
    nearest = distance;
    cure = fmt::format("; the nearest point that is: {:.4g},{:.4g}", p.x(), p.y());
    if (world_.dimension == 3) cure += fmt::format(",{:.4g}", p.z());
  });
  ThrowUsageError("world.goal {}: no point of it is free for a radius of {:.4g} m (most room: {:.4g} m){}",
                  Describe(world_.goal, world_.dimension), radius_, most_room, cure);
}

bool Reachability::CellCorner(const Vector3d& p, Eigen::Vector3i& corner) const {
  corner.setZero();
  for (int k = 0; k < world_.dimension; ++k) {
    if (!(p[k] >= world_.bounds.min[k] && p[k] <= world_.bounds.max[k])) return false;
    corner[k] = std::min(static_cast<int>((p[k] - world_.bounds.min[k]) / step_), nodes_[k] - 2);
  }
  return true;
}

void Reachability::Visit(const Eigen::Vector3i& node, std::vector<Eigen::Vector3i>& front) {
  char& reached = reached_[Index(node)];
  if (reached || field_.Distance(NodePosition(node)) < radius_) return;
  reached = 1;
  first_ = first_.cwiseMin(node);
  last_ = last_.cwiseMax(node);
  front.push_back(node);
  ++num_reached_;
}

// Marks the free corners of a free point's cell.
void Reachability::Seed(const Vector3d& p, std::vector<Eigen::Vector3i>& front) {
  Eigen::Vector3i corner;
  if (!CellCorner(p, corner)) return;
  for (int i = 0; i < 1 << world_.dimension; ++i) {
    Visit(corner + Eigen::Vector3i(i & 1, i >> 1 & 1, i >> 2 & 1), front);
  }
}

// Breadth first: the front stays as small as the world is wide, where a stack could hold all of its nodes.
void Reachability::Flood(std::vector<Eigen::Vector3i> front) {
  for (std::vector<Eigen::Vector3i> next_front; !front.empty(); front.swap(next_front)) {
    next_front.clear();
    for (const Eigen::Vector3i& node : front) {
      for (int k = 0; k < world_.dimension; ++k) {
        for (const int step : {-1, 1}) {
          Eigen::Vector3i next = node;
          next[k] += step;
          if (next[k] >= 0 && next[k] < nodes_[k]) Visit(next, next_front);
        }
      }
    }
  }
}

bool Reachability::Reaches(const Vector3d& p) const {
  Eigen::Vector3i corner;
  if (!CellCorner(p, corner)) return false;
  for (int i = 0; i < 1 << world_.dimension; ++i) {
    if (reached_[Index(corner + Eigen::Vector3i(i & 1, i >> 1 & 1, i >> 2 & 1))]) return true;
  }
  return false;
}

// Cells reach one node farther than their corners that are reached.
Box Reachability::extent() const {
  Box box;
  for (int k = 0; k < world_.dimension; ++k) {
    box.min[k] = world_.bounds.min[k] + step_ * std::max(0, first_[k] - 1);
    box.max[k] = std::min(world_.bounds.max[k], world_.bounds.min[k] + step_ * (last_[k] + 1));
  }
  return box;
}

void Reachability::CheckStart() const {
  bool any_free = false, any_reaches = false;
  ForEachPoint(world_.start, world_.dimension, step_, [&](const Vector3d& p) {
    if (any_reaches) return;
    const bool free = field_.Distance(p) >= radius_;
    any_free |= free;
    any_reaches |= free && Reaches(p);
  });
  if (any_reaches) return;
  const std::string start = Describe(world_.start, world_.dimension), goal = Describe(world_.goal, world_.dimension);
  if (!any_free) ThrowUsageError("world.start {}: no point of it is free for a radius of {:.4g} m", start, radius_);
  ThrowUsageError("world.goal {}: cannot be reached from world.start {} with a radius of {:.4g} m", goal, start,
                  radius_);
}

}  // namespace cairn
