#include "planner/collision/swept_sphere_checker.h"

#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/core/check.h"
#include "planner/collision/segment_distance.h"

namespace cairn::planner {
namespace {

// Whether a cylinder touches the sphere swept from a to b.
bool Touches(const Cylinder& c, double radius, const Vector3d& a, const Vector3d& b) {
  using Object = fcl::CollisionObject<double>;  // computes its bounding box when it is made
  const Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();
  const Object cylinder(std::make_shared<fcl::Cylinder<double>>(c.radius, c.height), upright,
                        c.base + Vector3d(0, 0, 0.5 * c.height));
  const auto rotation =
      a == b ? upright : Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), b - a).toRotationMatrix();
  const Object capsule(std::make_shared<fcl::Capsule<double>>(radius, (b - a).norm()), rotation, 0.5 * (a + b));
  fcl::CollisionRequest<double> request;  // yes or no, no contact points
  fcl::CollisionResult<double> result;
  return fcl::collide(&capsule, &cylinder, request, result) > 0;
}

}  // namespace

SweptSphereChecker::SweptSphereChecker(const World& world, double radius)
    : world_(world), radius_(radius), buckets_(world_) {
  CAIRN_CHECK(radius > 0, "radius {}", radius);
}

// The bounds are convex, so the ends of a motion decide for all of it. NaN is outside.
bool SweptSphereChecker::InBounds(const Vector3d& p) const {
  for (int k = 0; k < world_.dimension; ++k) {
    if (!(p[k] > world_.bounds.min[k] + radius_ && p[k] < world_.bounds.max[k] - radius_)) return false;
  }
  return true;
}

// By the exact distance between the segment and each box near it. In the plane z is 0 everywhere.
bool SweptSphereChecker::TouchesAny(Vector3d a, Vector3d b) const {
  const bool plane = world_.dimension == 2;
  if (plane) a.z() = b.z() = 0;
  const Box reach{a.cwiseMin(b).array() - radius_, a.cwiseMax(b).array() + radius_};
  return buckets_.AnyNear(reach, [&](int obstacle) {
    const auto number = static_cast<size_t>(obstacle);
    if (number < world_.boxes.size()) {
      Box box = world_.boxes[number];
      if (plane) box.min.z() = box.max.z() = 0;
      return SegmentDistance(box, a, b) <= radius_;
    }
    const Cylinder& c = world_.cylinders[number - world_.boxes.size()];
    if (!plane) return Touches(c, radius_, a, b);
    const Vector3d center(c.base.x(), c.base.y(), 0);
    return SegmentDistance({center, center}, a, b) <= radius_ + c.radius;
  });
}

bool SweptSphereChecker::Free(const Vector3d& p) const { return MotionFree(p, p); }

bool SweptSphereChecker::MotionFree(const Vector3d& a, const Vector3d& b) const {
  return InBounds(a) && InBounds(b) && !TouchesAny(a, b);
}

}  // namespace cairn::planner
