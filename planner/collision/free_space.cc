#include "planner/collision/free_space.h"

namespace cairn::planner {
namespace {

// Volatile, since g++ 12 makes a plain copy of two neighbouring components that go to float and back.
double RoundToFloat(double x) {
  const volatile float rounded = static_cast<float>(x);
  return rounded;
}

}  // namespace

Vector3d RoundToFloat(const Vector3d& p, int dimension) {
  return {RoundToFloat(p.x()), RoundToFloat(p.y()), dimension == 3 ? RoundToFloat(p.z()) : 0};
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
