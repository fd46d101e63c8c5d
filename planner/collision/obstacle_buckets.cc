#include "planner/collision/obstacle_buckets.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/core/check.h"

namespace cairn::planner {
namespace {

constexpr double kMaxCells = 4194304;

// Near the mean distance between obstacles, so that a cell holds about one.
double ChooseCell(const World& world) {
  const double obstacles = static_cast<double>(world.boxes.size() + world.cylinders.size() + 1);
  double volume = 1;
  for (int k = 0; k < world.dimension; ++k) volume *= world.bounds.size()[k];
  return std::pow(volume / std::min(2 * obstacles, kMaxCells), 1.0 / world.dimension);
}

}  // namespace

ObstacleBuckets::ObstacleBuckets(const World& world)
    : world_(world), inverse_cell_(1 / ChooseCell(world)), cells_(1, 1, 1) {
  for (int k = 0; k < world.dimension; ++k) cells_[k] = static_cast<int>(world.bounds.size()[k] * inverse_cell_) + 1;
  offsets_.assign(static_cast<size_t>(cells_.x()) * cells_.y() * cells_.z() + 1, 0);
  int64_t total = 0;
  ForEachCellAndObstacle([&](size_t cell, int) {
    ++offsets_[cell + 1];
    ++total;
  });
  CAIRN_CHECK(total <= INT32_MAX, "{} obstacles in the buckets", total);
  std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
  items_.resize(static_cast<size_t>(total));
  std::vector<int32_t> next(offsets_.begin(), offsets_.end() - 1);
  ForEachCellAndObstacle([&](size_t cell, int obstacle) { items_[next[cell]++] = obstacle; });
}

template <typename Visit>
void ObstacleBuckets::ForEachCellAndObstacle(const Visit& visit) const {
  const int count = static_cast<int>(world_.boxes.size() + world_.cylinders.size());
  for (int i = 0; i < count; ++i) {
    const Box box = BoundsOf(i);
    const Eigen::Vector3i low = CellOf(box.min), high = CellOf(box.max);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) visit(Index(x, y, z), i);
      }
    }
  }
}

Box ObstacleBuckets::BoundsOf(int obstacle) const {
  const auto number = static_cast<size_t>(obstacle);
  if (number < world_.boxes.size()) return world_.boxes[number];
  const Cylinder& c = world_.cylinders[number - world_.boxes.size()];
  const Vector3d half(c.radius, c.radius, 0);
  return {c.base - half, c.base + half + Vector3d(0, 0, c.height)};
}

bool ObstacleBuckets::Touch(const Box& a, const Box& b) const {
  for (int k = 0; k < world_.dimension; ++k) {
    if (a.min[k] > b.max[k] || b.min[k] > a.max[k]) return false;
  }
  return true;
}

// Monotone in each coordinate: whatever the rounding, boxes that touch share a cell.
Eigen::Vector3i ObstacleBuckets::CellOf(const Vector3d& p) const {
  Eigen::Vector3i cell(0, 0, 0);
  for (int k = 0; k < world_.dimension; ++k) {
    const double u = std::floor((p[k] - world_.bounds.min[k]) * inverse_cell_);
    cell[k] = static_cast<int>(std::clamp<double>(u, 0, cells_[k] - 1));
  }
  return cell;
}

}  // namespace cairn::planner
