#include "planner/collision/swept_sphere_checker.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/core/check.h"

namespace cairn::planner {
namespace {

using Object = fcl::CollisionObject<double>;
using Geometry = std::shared_ptr<fcl::CollisionGeometry<double>>;

Object MakeObject(Geometry geometry, const Vector3d& center, const Eigen::Matrix3d& rotation) {
  return Object(std::move(geometry), rotation, center);  // computes its bounding box here, once
}

// Called for each obstacle whose bounding box overlaps; true ends the query.
bool Touches(Object* a, Object* b, void* hit) {
  fcl::CollisionRequest<double> request;  // yes or no, no contact points
  fcl::CollisionResult<double> result;
  fcl::collide(a, b, request, result);
  *static_cast<bool*>(hit) = result.isCollision();
  return result.isCollision();
}

}  // namespace

struct SweptSphereChecker::Fcl {
  std::vector<Object> objects;
  fcl::DynamicAABBTreeCollisionManager<double> manager;

  // In the plane everything stands astride z = 0, where the sphere moves, and is taller than the sphere: the nearest
  // point of an obstacle then is the plane's.
  Fcl(const World& world, double radius) {
    objects.reserve(world.boxes.size() + world.cylinders.size());
    const auto add = [&](Geometry geometry, Vector3d center) {
      if (world.dimension == 2) center.z() = 0;
      objects.push_back(MakeObject(std::move(geometry), center, Eigen::Matrix3d::Identity()));
    };
    const double tall = 4 * radius;
    for (const Box& box : world.boxes) {
      const Vector3d size = box.size();
      add(std::make_shared<fcl::Box<double>>(size.x(), size.y(), world.dimension == 2 ? tall : size.z()), box.center());
    }
    for (const Cylinder& c : world.cylinders) {
      add(std::make_shared<fcl::Cylinder<double>>(c.radius, world.dimension == 2 ? tall : c.height),
          c.base + Vector3d(0, 0, 0.5 * c.height));
    }
    for (Object& object : objects) manager.registerObject(&object);
    manager.setup();
  }

  bool Free(Object object) {
    bool hit = false;
    manager.collide(&object, &hit, &Touches);
    return !hit;
  }
};

SweptSphereChecker::SweptSphereChecker(const World& world, double radius, const DistanceField* field)
    : dimension_(world.dimension),
      radius_(radius),
      bounds_(world.bounds),
      field_(field),
      fcl_(std::make_unique<Fcl>(world, radius)) {
  CAIRN_CHECK(radius > 0, "radius {}", radius);
}

SweptSphereChecker::~SweptSphereChecker() = default;

// The bounds are convex, so the ends of a motion decide for all of it. NaN is outside.
bool SweptSphereChecker::InBounds(const Vector3d& p) const {
  for (int k = 0; k < dimension_; ++k) {
    if (!(p[k] > bounds_.min[k] + radius_ && p[k] < bounds_.max[k] - radius_)) return false;
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

bool SweptSphereChecker::Free(const Vector3d& p) const {
  if (!InBounds(p)) return false;
  const Proof proof = Trace(p, p);
  if (proof != Proof::kNone) return proof == Proof::kFree;
  return fcl_->Free(MakeObject(std::make_shared<fcl::Sphere<double>>(radius_), p, Eigen::Matrix3d::Identity()));
}

bool SweptSphereChecker::MotionFree(const Vector3d& a, const Vector3d& b) const {
  if (a == b) return Free(a);
  if (!InBounds(a) || !InBounds(b)) return false;
  const Proof proof = Trace(a, b);
  if (proof != Proof::kNone) return proof == Proof::kFree;
  const Vector3d ab = b - a;
  const auto capsule = std::make_shared<fcl::Capsule<double>>(radius_, ab.norm());
  const auto rotation = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), ab);
  return fcl_->Free(MakeObject(capsule, 0.5 * (a + b), rotation.toRotationMatrix()));
}

}  // namespace cairn::planner
