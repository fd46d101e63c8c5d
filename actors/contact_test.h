#pragma once

#include "actors/motion.h"
#include "actors/scene.h"

namespace cairn::actors {

/// Tests a vehicle's footprint against walls and bounds, for every physics step: the distance field at the centre
/// answers far from obstacles (a few ns), the obstacles themselves exactly near them.
class ContactTest {
 public:
  /// `scene` must outlive it.
  explicit ContactTest(const Scene& scene)
      : scene_(scene), footprint_(scene.footprint()), radius_(footprint_.circumscribed_radius()) {}

  /// Field at the vehicle's centre [m].
  double CenterDistance(const Motion& motion) const {
    return scene_.field().Distance(Vector3d(motion.x, motion.y, motion.z));
  }

  /// True when the footprint touches; `center_distance` from above.
  bool Touches(const Motion& motion, double center_distance) const {
    // The interpolated field is off by less than 0.87 resolutions.
    return center_distance < radius_ + scene_.field().resolution() && TouchesExactly(motion);
  }

  const Footprint& footprint() const { return footprint_; }

 private:
  bool TouchesExactly(const Motion& motion) const {
    if (scene_.world().dimension == 3) {
      return scene_.space_obstacles().Overlaps(Vector3d(motion.x, motion.y, motion.z), footprint_.radius);
    }
    return scene_.obstacles().Overlaps(motion.x, motion.y, motion.yaw, footprint_);
  }

  const Scene& scene_;
  Footprint footprint_;
  double radius_;
};

}  // namespace cairn::actors
