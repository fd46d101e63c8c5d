#pragma once

#include <algorithm>
#include <vector>

#include "planner/builders/point_tree.h"
#include "planner/collision/free_space.h"

namespace cairn::planner {

/// Share of free space within r_ball of a vertex, estimated on fixed samples.
class Coverage {
 public:
  /// Draws `samples` points of free space, from which the goal can be reached. Throws Error when there are none.
  Coverage(const FreeSpace& space, double r_ball, int samples, uint64_t seed);

  /// Counts what a new vertex covers.
  void AddVertex(const Vector3d& p);

  /// Share of free space for which `near` says that a vertex is near, whatever was added.
  template <typename Near>
  double ShareOf(const Near& near) const {
    return static_cast<double>(std::count_if(samples_.begin(), samples_.end(), near)) /
           static_cast<double>(samples_.size());
  }

  const std::vector<Vector3d>& samples() const { return samples_; }

  double share() const { return static_cast<double>(num_covered_) / static_cast<double>(samples_.size()); }

 private:
  double r_ball_;
  std::vector<Vector3d> samples_;
  PointTree tree_;  // of samples_
  std::vector<char> covered_;
  std::vector<int32_t> found_;  // scratch
  int num_covered_ = 0;
};

}  // namespace cairn::planner
