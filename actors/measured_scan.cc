#include "actors/measured_scan.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "actors/observation.h"

namespace cairn::actors {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// Number of the beam that is nearest to an angle; −1: the angle lies half a step or more outside.
long BeamAt(double angle, double angle_min, double angle_step, size_t n) {
  const auto size = static_cast<double>(n);
  double at = std::remainder(angle - angle_min, kTurn);
  if (at < -0.5 * angle_step) at += kTurn;
  const double beam = std::round(at / angle_step);
  if (beam < size) return static_cast<long>(beam);
  // The last beam may be nearer from the other side, as may the first.
  const double from_first = kTurn - at;
  if (from_first <= 0.5 * angle_step * (1 + 1e-9)) return 0;
  return at - (size - 1) * angle_step <= 0.5 * angle_step * (1 + 1e-9) ? static_cast<long>(n) - 1 : -1;
}

}  // namespace

MeasuredScan::MeasuredScan(const VehicleConfig& vehicle)
    : vehicle_(vehicle), beams_(BeamDirections(vehicle.scan, vehicle.dimension())) {
  ranges_.assign(beams_.size(), 0);  // nothing was seen
}

std::string MeasuredScan::Fault(double angle_min, double angle_step, size_t n) const {
  if (vehicle_.dimension() == 3) {
    return n == beams_.size() ? "" : fmt::format("num_ranges is {}; vehicle.scan has {} beams", n, beams_.size());
  }
  if (n == 0) return "num_ranges is 0";
  if (!std::isfinite(angle_min)) return fmt::format("angle_min is {}; it must be finite", angle_min);
  if (!(angle_step > 0 && angle_step <= kTurn)) {
    return fmt::format("angle_step is {}; it must be above 0 and at most 2 pi", angle_step);
  }
  for (size_t i = 0; i < beams_.size(); ++i) {
    const double angle = std::atan2(beams_[i].y(), beams_[i].x());
    if (BeamAt(angle, angle_min, angle_step, n) < 0) {
      return fmt::format("the ranges cover {:.3f} to {:.3f} rad; beam {} of vehicle.scan looks at {:.3f} rad",
                         angle_min, angle_min + static_cast<double>(n - 1) * angle_step, i, angle);
    }
  }
  return "";
}

std::string MeasuredScan::Set(const Motion& motion, double angle_min, double angle_step,
                              std::span<const float> ranges) {
  std::string fault = Fault(angle_min, angle_step, ranges.size());
  if (!fault.empty()) return fault;
  cos_ = std::cos(motion.yaw);
  sin_ = std::sin(motion.yaw);
  angle_min_ = angle_min;
  angle_step_ = angle_step;
  ranges_.assign(ranges.begin(), ranges.end());
  return "";
}

size_t MeasuredScan::NearestBeam(const Vector3d& ahead) const {
  if (vehicle_.dimension() == 2) {
    const long beam = BeamAt(std::atan2(ahead.y(), ahead.x()), angle_min_, angle_step_, ranges_.size());
    return beam < 0 ? ranges_.size() : static_cast<size_t>(beam);
  }
  const auto nearest = std::max_element(
      beams_.begin(), beams_.end(), [&](const Vector3d& a, const Vector3d& b) { return a.dot(ahead) < b.dot(ahead); });
  return static_cast<size_t>(nearest - beams_.begin());
}

double MeasuredScan::Range(const Vector3d& direction, double max_range) const {
  const Vector3d ahead(cos_ * direction.x() + sin_ * direction.y(), cos_ * direction.y() - sin_ * direction.x(),
                       direction.z());
  const size_t beam = NearestBeam(ahead);
  if (beam >= ranges_.size()) return max_range;
  const double range = ranges_[beam];
  return std::isfinite(range) && range > 0 ? std::min(range, max_range) : max_range;
}

}  // namespace cairn::actors
