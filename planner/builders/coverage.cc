#include "planner/builders/coverage.h"

#include "common/core/check.h"

namespace cairn::planner {

Coverage::Coverage(const FreeSpace& space, double r_ball, int samples, uint64_t seed)
    : r_ball_(r_ball), tree_(space.world().dimension), covered_(samples, 0) {
  RandomStream random(seed, RandomPurpose::kPlanner, 1);
  for (int i = 0; i < samples; ++i) {
    const auto p = space.Draw(random);
    if (!p) ThrowError("world.bounds: free space is too small a part of it for a roadmap by sampling");
    samples_.push_back(*p);
    tree_.Add(*p);
  }
}

void Coverage::AddVertex(const Vector3d& p) {
  tree_.Within(p, r_ball_, found_);
  for (const int32_t i : found_) {
    num_covered_ += !covered_[i];
    covered_[i] = 1;
  }
}

}  // namespace cairn::planner
