#pragma once

#include <algorithm>

#include "actors/motion.h"
#include "actors/persons.h"
#include "actors/scene.h"

namespace cairn::actors {

/// Tests a vehicle's footprint against walls, bounds and people, for every physics step: the distance field at the
/// centre answers far from obstacles (a few ns), the obstacles themselves exactly near them.
class ContactTest {
 public:
  /// `scene` and `persons` (which may be null) must outlive it.
  explicit ContactTest(const Scene& scene, const Persons* persons = nullptr)
      : scene_(scene), persons_(persons), footprint_(scene.footprint()), radius_(footprint_.circumscribed_radius()) {}

  /// The footprint is this many times that of the vehicle's description (environment.footprint_scale).
  void SetScale(double scale) {
    const Footprint& own = scene_.footprint();
    footprint_ = {scale * own.half_length, scale * own.half_width, scale * own.radius};
    radius_ = footprint_.circumscribed_radius();
  }

  /// Field at the vehicle's centre [m], or the distance to the nearest person if that is less.
  double CenterDistance(const Motion& motion) const {
    const Vector3d p(motion.x, motion.y, motion.z);
    const double distance = scene_.field().Distance(p);
    return persons_ == nullptr ? distance : std::min(distance, persons_->Distance(p));
  }

  /// True when the footprint touches; `center_distance` from above.
  bool Touches(const Motion& motion, double center_distance) const {
    // The interpolated field is off by less than 0.87 resolutions.
    return center_distance < radius_ + scene_.field().resolution() && TouchesExactly(motion);
  }

  /// The footprint as it touches.
  const Footprint& footprint() const { return footprint_; }

  /// The smaller of `upper` [m] and the distance from the footprint to people, at least 0.
  double PersonClearance(const Motion& motion, double upper) const {
    return persons_ == nullptr ? upper : std::min(upper, persons_->Clearance(motion.pose(), footprint_));
  }

 private:
  bool TouchesExactly(const Motion& motion) const {
    if (persons_ != nullptr && persons_->Clearance(motion.pose(), footprint_) <= 0) return true;
    if (scene_.world().dimension == 3) {
      return scene_.space_obstacles().Overlaps(Vector3d(motion.x, motion.y, motion.z), footprint_.radius);
    }
    return scene_.obstacles().Overlaps(motion.x, motion.y, motion.yaw, footprint_);
  }

  const Scene& scene_;
  const Persons* persons_;
  Footprint footprint_;
  double radius_;
};

}  // namespace cairn::actors
