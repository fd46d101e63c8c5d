#pragma once

#include <span>
#include <string>
#include <vector>

#include "actors/motion.h"
#include "common/config/experiment.h"
#include "common/world/world.h"

namespace cairn::actors {

/// A look around that a real robot's sensor took, in the place of the world that a simulated one looks into. In the
/// plane any scan that covers the experiment's beams; in space those beams.
class MeasuredScan {
 public:
  explicit MeasuredScan(const VehicleConfig& vehicle);

  /// Takes over a scan taken at `motion`: range i [m] lies at angle_min + i · angle_step [rad] in the body frame, 0
  /// ahead, left positive; not finite, 0 or less, or beyond scan.range: nothing was seen. In space the angles mean
  /// nothing. Returns what is wrong with it and leaves the last one; empty: nothing.
  std::string Set(const Motion& motion, double angle_min, double angle_step, std::span<const float> ranges);

  /// Distance [m] from p along a unit vector of W, 0 to `max_range`: from the sensor by the beam that is nearest to the
  /// direction; in the plane from elsewhere to the line through the ends of the beams.
  double Range(const Vector3d& p, const Vector3d& direction, double max_range) const;

  /// The least of the ranges [m].
  double nearest() const;

 private:
  std::string Fault(double angle_min, double angle_step, size_t n) const;
  Vector3d ToBody(const Vector3d& v) const { return {cos_ * v.x() + sin_ * v.y(), cos_ * v.y() - sin_ * v.x(), v.z()}; }
  double RangeOf(size_t beam, double none) const;
  size_t NearestBeam(const Vector3d& ahead) const;
  double ToOutline(const Vector3d& p, const Vector3d& ahead, double max_range) const;

  const VehicleConfig vehicle_;
  std::vector<Vector3d> beams_;         // of the experiment, in the body frame
  double cos_ = 1, sin_ = 0;            // of the yaw
  Vector3d sensor_ = Vector3d::Zero();  // in W
  double angle_min_ = 0, angle_step_ = 1;
  std::vector<float> ranges_;
};

}  // namespace cairn::actors
