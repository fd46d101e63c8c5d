#include "actors/clearance.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cairn::actors {
namespace {

constexpr double kTolerance = 0.08;  // of the half width: 2 mm for the paper's car

struct Sample {
  Vector3d p;
  double distance;
};

// The field changes by at most 1 m per metre, so between a and b it stays above (d_a + d_b − |a − b|) / 2. Stops where
// less than half the tolerance is to be gained.
double EdgeClearance(const DistanceField& field, const Sample& a, const Sample& b, double tolerance, double upper) {
  const double length = (b.p - a.p).norm();
  if (0.5 * (a.distance + b.distance - length) >= upper - 0.5 * tolerance) return upper;
  const Vector3d p = 0.5 * (a.p + b.p);
  const Sample middle{p, field.Distance(p)};
  upper = std::min(upper, middle.distance);
  upper = EdgeClearance(field, a, middle, tolerance, upper);
  return EdgeClearance(field, middle, b, tolerance, upper);
}

}  // namespace

double FootprintClearance(const DistanceField& field, const Pose& pose, const Footprint& footprint,
                          double center_distance, double upper) {
  const double radius = footprint.circumscribed_radius();
  if (center_distance - radius >= upper) return upper;
  if (footprint.radius > 0) return std::max(center_distance - radius, 0.0);
  const Vector3d center(pose.x, pose.y, 0);
  const Vector3d forward = footprint.half_length * Vector3d(std::cos(pose.yaw), std::sin(pose.yaw), 0);
  const Vector3d left = footprint.half_width * Vector3d(-std::sin(pose.yaw), std::cos(pose.yaw), 0);
  std::array<Sample, 4> corners{{{center + forward + left, 0},
                                 {center - forward + left, 0},
                                 {center - forward - left, 0},
                                 {center + forward - left, 0}}};
  for (Sample& corner : corners) {
    corner.distance = field.Distance(corner.p);
    upper = std::min(upper, corner.distance);
  }
  for (int i = 0; i < 4; ++i) {
    upper = EdgeClearance(field, corners[i], corners[(i + 1) % 4], kTolerance * footprint.half_width, upper);
  }
  return std::max(upper, 0.0);
}

}  // namespace cairn::actors
