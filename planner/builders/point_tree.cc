#include "planner/builders/point_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn::planner {

double PointTree::SquaredDistance(const Vector3d& a, const Vector3d& b) const {
  return dimension_ == 2 ? (a - b).head<2>().squaredNorm() : (a - b).squaredNorm();
}

void PointTree::Add(const Vector3d& p) {
  const auto number = static_cast<int32_t>(nodes_.size());
  int32_t axis = 0;
  for (int32_t at = number == 0 ? -1 : 0; at >= 0;) {
    Node& node = nodes_[at];
    int32_t& child = node.child[p[node.axis] < node.point[node.axis] ? 0 : 1];
    axis = (node.axis + 1) % dimension_;
    at = child;
    if (child < 0) child = number;
  }
  nodes_.push_back({p, axis, {-1, -1}});
}

int PointTree::Nearest(const Vector3d& p) const {
  if (nodes_.empty()) return -1;
  int32_t best = 0;
  double best_squared = std::numeric_limits<double>::infinity();
  stack_.assign(1, 0);
  std::vector<int32_t>& stack = stack_;
  while (!stack.empty()) {
    // An entry ~n (negative) is the far side of node n, taken only if the splitting plane is near enough by then.
    int32_t at = stack.back();
    stack.pop_back();
    if (at < 0) {
      const Node& node = nodes_[~at];
      const double offset = p[node.axis] - node.point[node.axis];
      if (offset * offset > best_squared) continue;
      at = node.child[offset < 0 ? 1 : 0];
    }
    while (at >= 0) {
      const Node& node = nodes_[at];
      const double squared = SquaredDistance(node.point, p);
      if (squared < best_squared || (squared == best_squared && at < best)) {
        best = at;
        best_squared = squared;
      }
      const int side = p[node.axis] < node.point[node.axis] ? 0 : 1;
      if (node.child[1 - side] >= 0) stack.push_back(~at);
      at = node.child[side];
    }
  }
  return best;
}

// Goes down p's side first, where a near point is found soon if there is one.
bool PointTree::AnyNearer(const Vector3d& p, double radius) const {
  const double limit = radius * radius;
  stack_.assign(nodes_.empty() ? 0 : 1, 0);
  while (!stack_.empty()) {
    const Node& node = nodes_[stack_.back()];
    stack_.pop_back();
    if (SquaredDistance(node.point, p) < limit) return true;
    const double offset = p[node.axis] - node.point[node.axis];
    const int side = offset < 0 ? 0 : 1;
    if (node.child[1 - side] >= 0 && std::abs(offset) < radius) stack_.push_back(node.child[1 - side]);
    if (node.child[side] >= 0) stack_.push_back(node.child[side]);
  }
  return false;
}

void PointTree::Within(const Vector3d& p, double radius, std::vector<int32_t>& found) const {
  found.clear();
  const double limit = radius * radius;
  stack_.assign(nodes_.empty() ? 0 : 1, 0);
  while (!stack_.empty()) {
    const int32_t at = stack_.back();
    stack_.pop_back();
    const Node& node = nodes_[at];
    if (SquaredDistance(node.point, p) <= limit) found.push_back(at);
    const double offset = p[node.axis] - node.point[node.axis];
    if (node.child[0] >= 0 && offset <= radius) stack_.push_back(node.child[0]);
    if (node.child[1] >= 0 && offset >= -radius) stack_.push_back(node.child[1]);
  }
  std::sort(found.begin(), found.end());
}

}  // namespace cairn::planner
