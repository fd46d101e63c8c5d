#pragma once

#include <span>
#include <vector>

#include "actors/motion.h"
#include "actors/range_finder.h"
#include "actors/scene.h"

namespace cairn::actors {

/// Turns a vehicle's state into what the policy sees. Entries in the order of ObservationConfig, each part switchable:
/// position 2, heading 2, velocity 2 (forward speed, yaw rate), d_min 1, look_ahead 2 × 2, rays scan.beams. In space
/// position 3, no heading, velocity 3, look_ahead 2 × 3; HOLONOMIC has velocity 3 (vx, vy, yaw rate). At the end the
/// last actions. Stateless after construction.
class ObservationBuilder {
 public:
  /// `scene` must outlive the builder; its table is read at each call.
  explicit ObservationBuilder(const Scene& scene);

  /// Number of floats that Build writes.
  int size() const { return size_; }

  /// Writes the observation of a finite motion by a vehicle that takes `believed` for its pose and sees `ranges`;
  /// `d_min` [m]; `last_actions` newest first.
  void Build(const Motion& motion, const Pose& believed, float d_min, RangeFinder& ranges,
             std::span<const float> last_actions, float* out) const;

  /// The same without noise, people and earlier actions.
  void Build(const Motion& motion, float d_min, float* out) const;

 private:
  float* Position(const Pose& pose, float* out) const;
  float* Heading(const Pose& pose, float* out) const;
  float* Velocity(const Motion& motion, float* out) const;
  float* DMin(float d_min, float* out) const;
  float* LookAhead(const Pose& pose, float* out) const;
  float* Rays(const Motion& motion, RangeFinder& ranges, float* out) const;

  const Scene& scene_;
  const ObservationConfig& config_;
  const VehicleConfig& vehicle_;
  std::vector<Vector3d> beams_;  // unit vectors in the body frame
  double nearest_ray_;           // [m] no shorter range happens without a collision
  double radius_;
  int size_;
};

/// Angle [rad] of beam i in the body frame, in the plane: a full circle starts straight ahead and turns left in equal
/// steps; a part of one spreads from −field_of_view/2 to +field_of_view/2, ends included.
double BeamAngle(const ScanConfig& scan, int beam);

/// Unit vectors of the beams in the body frame. In space: the 6 directions of the axes, then the 8 diagonals of the
/// cube, then the 12 of its faces, as far as `scan.beams` goes.
std::vector<Vector3d> BeamDirections(const ScanConfig& scan, int dimension);

}  // namespace cairn::actors
