#include "actors/measured_scan.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "actors/observation.h"

namespace cairn::actors {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kHere = 1e-6;  // [m] from the sensor

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
  const double mount = vehicle_.scan.mount_x;
  sensor_ = {motion.x + cos_ * mount, motion.y + sin_ * mount, motion.z};
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

double MeasuredScan::RangeOf(size_t beam, double none) const {
  const double range = ranges_[beam];
  return std::isfinite(range) && range > 0 ? std::min(range, none) : none;
}

double MeasuredScan::nearest() const {
  double nearest = vehicle_.scan.range;
  for (size_t beam = 0; beam < ranges_.size(); ++beam) nearest = std::min(nearest, RangeOf(beam, nearest));
  return nearest;
}

// From p, seen from the sensor in the body frame, along `ahead` to the first of the straight lines between the ends of
// neighbouring beams. What lies behind a corner that the sensor cannot see past counts as taken.
double MeasuredScan::ToOutline(const Vector3d& p, const Vector3d& ahead, double max_range) const {
  const size_t n = ranges_.size();
  const bool closed = static_cast<double>(n) * angle_step_ > kTurn - 0.5 * angle_step_;
  const auto end = [&](size_t beam) {
    const double angle = angle_min_ + static_cast<double>(beam) * angle_step_,
                 range = RangeOf(beam, vehicle_.scan.range);
    return Vector3d(range * std::cos(angle) - p.x(), range * std::sin(angle) - p.y(), 0);
  };
  const auto cross = [](const Vector3d& a, const Vector3d& b) { return a.x() * b.y() - a.y() * b.x(); };
  double nearest = max_range;
  Vector3d from = end(closed ? n - 1 : 0);
  for (size_t beam = closed ? 0 : 1; beam < n; ++beam) {
    const Vector3d to = end(beam), way = to - from;
    const double turn = cross(ahead, way);  // from + s way = t ahead
    const double t = cross(from, way) / turn, s = cross(from, ahead) / turn;
    if (turn != 0 && t >= 0 && s >= 0 && s <= 1) nearest = std::min(nearest, t);
    from = to;
  }
  return nearest;
}

double MeasuredScan::Range(const Vector3d& p, const Vector3d& direction, double max_range) const {
  const Vector3d ahead = ToBody(direction), offset = ToBody(p - sensor_);
  if (vehicle_.dimension() == 2 && offset.norm() > kHere) return ToOutline(offset, ahead, max_range);
  const size_t beam = NearestBeam(ahead);
  return beam < ranges_.size() ? RangeOf(beam, max_range) : max_range;
}

}  // namespace cairn::actors
