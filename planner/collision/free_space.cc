#include "planner/collision/free_space.h"

namespace cairn::planner {

Vector3d RoundToFloat(const Vector3d& p, int dimension) {
  const Vector3d rounded = p.cast<float>().cast<double>();
  return dimension == 3 ? rounded : Vector3d(rounded.x(), rounded.y(), 0);
}

std::optional<Vector3d> FreeSpace::Draw(const Box& region, RandomStream& random) const {
  constexpr int kTries = 10000000;
  for (int i = 0; i < kTries; ++i) {
    Vector3d p = Vector3d::Zero();
    for (int k = 0; k < world_.dimension; ++k) p[k] = random.Uniform(region.min[k], region.max[k]);
    p = RoundToFloat(p, world_.dimension);
    if (Contains(p)) return p;
  }
  return std::nullopt;
}

}  // namespace cairn::planner
