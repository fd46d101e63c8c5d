#include "planner/collision/free_space.h"

namespace cairn::planner {
namespace {

// Volatile, since g++ 12 makes a plain copy of two neighbouring components that go to float and back.
double RoundToFloat(double x) {
  const volatile float rounded = static_cast<float>(x);
  return rounded;
}

// Free space that lies in a smaller part of the bounds is drawn from there: few draws from the bounds would meet it.
// The others keep their draws, and with them their roadmaps.
constexpr double kSmallPart = 0.5;

double Volume(const Box& box, int dimension) {
  const Vector3d size = box.size();
  return size.x() * size.y() * (dimension == 3 ? size.z() : 1);
}

}  // namespace

FreeSpace::FreeSpace(const World& world, const SweptSphereChecker& checker, const Reachability& reachability)
    : world_(world), checker_(checker), reachability_(reachability), region_(reachability.extent()) {
  const bool small = Volume(region_, world.dimension) < kSmallPart * Volume(world.bounds, world.dimension);
  if (!small) region_ = world.bounds;
}

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
