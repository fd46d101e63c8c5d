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

SweptSphereChecker::SweptSphereChecker(const World& world, double radius, const DistanceField* field)
    : world_(world), radius_(radius), field_(field), buckets_(world_) {
  CAIRN_CHECK(radius > 0, "radius {}", radius);
}

// The bounds are convex, so the ends of a motion decide for all of it. NaN is outside.
bool SweptSphereChecker::InBounds(const Vector3d& p) const {
  for (int k = 0; k < world_.dimension; ++k) {
    if (!(p[k] > world_.bounds.min[k] + radius_ && p[k] < world_.bounds.max[k] - radius_)) return false;
  }
  return true;
}

// Sphere tracing. With e the field's interpolation error, field < radius − e proves contact; field ≥ radius + e at
// points no farther apart than what is to spare there proves freedom; else nothing is proven.
SweptSphereChecker::Proof SweptSphereChecker::Trace(const Vector3d& a, const Vector3d& b) const {
  if (!field_) return Proof::kNone;
  const Vector3d ab = b - a;
  const double length = ab.norm();
  const double hit = radius_ - field_->interpolation_error(), free = radius_ + field_->certified_margin();
  Proof proof = Proof::kFree;
  for (double s = 0;; s = std::min(s, length)) {
    const double distance = field_->Distance(length > 0 ? Vector3d(a + ab * (s / length)) : a);
    if (distance < hit) return Proof::kHit;
    if (distance < free) proof = Proof::kNone;
    if (s >= length) return proof;
    s += std::max(distance - free, proof == Proof::kFree ? field_->smallest_step() : field_->resolution());
  }
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
  if (!InBounds(a) || !InBounds(b)) return false;
  const Proof proof = Trace(a, b);
  return proof == Proof::kNone ? !TouchesAny(a, b) : proof == Proof::kFree;
}

}  // namespace cairn::planner
