#pragma once

#include "actors/scene.h"
#include "actors/vehicles/vehicle.h"

namespace cairn::actors {

/// Tests a vehicle's footprint against walls and bounds, for every physics step: the distance field at the centre
/// answers far from obstacles (a few ns), the obstacle grid exactly near them.
class ContactTest {
 public:
  /// `scene` must outlive it.
  explicit ContactTest(const Scene& scene)
      : scene_(scene),
        footprint_{0.5 * scene.experiment().vehicle.length, 0.5 * scene.experiment().vehicle.width},
        // The interpolated field is off by less than 0.71 resolutions.
        safe_distance_(scene.experiment().vehicle.circumscribed_radius() + scene.field().resolution()) {}

  /// Field at the vehicle's centre [m].
  double CenterDistance(const GroundState& state) const {
    return scene_.field().Distance(Vector3d(state.x, state.y, 0));
  }

  /// True when the footprint touches; `center_distance` from above.
  bool Touches(const GroundState& state, double center_distance) const {
    return center_distance < safe_distance_ && scene_.obstacles().Overlaps(state.x, state.y, state.yaw, footprint_);
  }

  const Footprint& footprint() const { return footprint_; }

 private:
  const Scene& scene_;
  Footprint footprint_;
  double safe_distance_;
};

}  // namespace cairn::actors
