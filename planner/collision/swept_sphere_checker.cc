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
#include "planner/collision/obstacle_buckets.h"

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

// In the plane everything stands astride z = 0, where the sphere moves, and is taller than the sphere: the nearest
// point of an obstacle then is the plane's.
Object MakeObstacle(const World& world, size_t obstacle, double radius) {
  const bool plane = world.dimension == 2;
  const double tall = 4 * radius;
  const auto object = [&](Geometry geometry, Vector3d center) {
    if (plane) center.z() = 0;
    return MakeObject(std::move(geometry), center, Eigen::Matrix3d::Identity());
  };
  if (obstacle < world.boxes.size()) {
    const Box& box = world.boxes[obstacle];
    const Vector3d size = box.size();
    return object(std::make_shared<fcl::Box<double>>(size.x(), size.y(), plane ? tall : size.z()), box.center());
  }
  const Cylinder& c = world.cylinders[obstacle - world.boxes.size()];
  return object(std::make_shared<fcl::Cylinder<double>>(c.radius, plane ? tall : c.height),
                c.base + Vector3d(0, 0, 0.5 * c.height));
}

}  // namespace

struct SweptSphereChecker::Fcl {
  virtual ~Fcl() = default;
  virtual bool Free(Object object) = 0;
};

// All obstacles in a tree.
struct SweptSphereChecker::Tree : SweptSphereChecker::Fcl {
  std::vector<Object> objects;
  fcl::DynamicAABBTreeCollisionManager<double> manager;

  Tree(const World& world, double radius) {
    const size_t count = world.boxes.size() + world.cylinders.size();
    objects.reserve(count);
    for (size_t i = 0; i < count; ++i) objects.push_back(MakeObstacle(world, i, radius));
    for (Object& object : objects) manager.registerObject(&object);
    manager.setup();
  }

  bool Free(Object object) override {
    bool hit = false;
    manager.collide(&object, &hit, &Touches);
    return !hit;
  }
};

// Obstacles of an imported map, made when they are asked for.
struct SweptSphereChecker::Buckets : SweptSphereChecker::Fcl {
  World world;
  double radius;
  ObstacleBuckets buckets;

  Buckets(const World& own, double own_radius) : world(own), radius(own_radius), buckets(world) {}

  bool Free(Object object) override {
    const Box box{object.getAABB().min_, object.getAABB().max_};
    return !buckets.AnyNear(box, [&](int obstacle) {
      Object other = MakeObstacle(world, static_cast<size_t>(obstacle), radius);
      bool hit = false;
      return Touches(&object, &other, &hit);
    });
  }
};

SweptSphereChecker::SweptSphereChecker(const World& world, double radius, const DistanceField* field)
    : dimension_(world.dimension), radius_(radius), bounds_(world.bounds), field_(field), fcl_(MakeFcl(world, radius)) {
  CAIRN_CHECK(radius > 0, "radius {}", radius);
}

std::unique_ptr<SweptSphereChecker::Fcl> SweptSphereChecker::MakeFcl(const World& world, double radius) {
  if (world.imported) return std::make_unique<Buckets>(world, radius);
  return std::make_unique<Tree>(world, radius);
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
