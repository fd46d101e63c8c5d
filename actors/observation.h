#pragma once

#include <vector>

#include "actors/scene.h"
#include "actors/vehicles/vehicle.h"

namespace cairn::actors {

/// Turns a vehicle's state into what the policy sees. Entries in the order of ObservationConfig, each part switchable:
/// position 2, heading 2, velocity 2, d_min 1, look_ahead 4, rays scan.beams. Stateless after construction.
class ObservationBuilder {
 public:
  /// `scene` must outlive the builder; its table is read at each call.
  explicit ObservationBuilder(const Scene& scene);

  /// Number of floats that Build writes.
  int size() const { return size_; }

  /// Writes the noise-free observation of a finite state; `d_min` [m].
  void Build(const GroundState& state, float d_min, float* out) const;

 private:
  float* Position(const GroundState& state, float* out) const;
  float* Heading(const GroundState& state, float* out) const;
  float* Velocity(const GroundState& state, float* out) const;
  float* DMin(float d_min, float* out) const;
  float* LookAhead(const GroundState& state, float* out) const;
  float* Rays(const GroundState& state, float* out) const;

  struct Direction {
    double x, y;
  };

  const Scene& scene_;
  const ObservationConfig& config_;
  const VehicleConfig& vehicle_;
  std::vector<Direction> beams_;  // unit vectors in the body frame
  double nearest_ray_;            // [m] no shorter range happens without a collision
  double radius_;
  int size_;
};

/// Angle [rad] of beam i in the body frame: a full circle starts straight ahead and turns left in equal steps; a part
/// of one spreads from −field_of_view/2 to +field_of_view/2, ends included.
double BeamAngle(const ScanConfig& scan, int beam);

}  // namespace cairn::actors
