#pragma once

#include <cstdint>
#include <vector>

#include "common/world/world.h"

namespace cairn::planner {

/// Which obstacles of a world may touch a box: a grid of buckets, filled in time linear in obstacles and cells. For
/// maps of a million boxes, on which a tree of bounding boxes takes minutes to build. Borrows the world.
class ObstacleBuckets {
 public:
  explicit ObstacleBuckets(const World& world);

  /// Calls visit(obstacle) for those whose bounding box touches `box`, some more than once, until it returns true;
  /// returns whether it did. Numbers below world.boxes.size() are boxes, then come cylinders.
  template <typename Visit>
  bool AnyNear(const Box& box, const Visit& visit) const {
    const Eigen::Vector3i low = CellOf(box.min), high = CellOf(box.max);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          const size_t cell = Index(x, y, z);
          for (int32_t k = offsets_[cell]; k < offsets_[cell + 1]; ++k) {
            if (Touch(BoundsOf(items_[k]), box) && visit(items_[k])) return true;
          }
        }
      }
    }
    return false;
  }

 private:
  Box BoundsOf(int obstacle) const;
  bool Touch(const Box& a, const Box& b) const;
  Eigen::Vector3i CellOf(const Vector3d& p) const;
  size_t Index(int x, int y, int z) const {
    return (static_cast<size_t>(z) * cells_.y() + y) * cells_.x() + static_cast<size_t>(x);
  }
  template <typename Visit>
  void ForEachCellAndObstacle(const Visit& visit) const;

  const World& world_;
  double inverse_cell_;  // 1 / side of a cell [1/m]
  Eigen::Vector3i cells_;
  std::vector<int32_t> offsets_, items_;  // cell → obstacles, CSR
};

}  // namespace cairn::planner
