#include "actors/vehicles/quadruped/leg.h"

#include <algorithm>
#include <cmath>

namespace cairn::actors {
namespace {

// Share of the straight leg's length that targets may use: a straight knee has no way to go.
constexpr double kReach = 0.98;

}  // namespace

// In the leg's plane, x forward and r down: x = −thigh sin h − shank sin (h + k), r = thigh cos h + shank cos (h + k).
FootPosition ForwardKinematics(const LegLengths& lengths, const LegAngles& angles) {
  const double both = angles.hip + angles.knee;
  const double r = lengths.thigh * std::cos(angles.hip) + lengths.shank * std::cos(both);
  return {-lengths.thigh * std::sin(angles.hip) - lengths.shank * std::sin(both), r * std::sin(angles.abduction),
          -r * std::cos(angles.abduction)};
}

LegAngles InverseKinematics(const LegLengths& lengths, const FootPosition& foot) {
  const double a = lengths.thigh, b = lengths.shank;
  const double r = std::sqrt(foot.y * foot.y + foot.z * foot.z);
  const double reach = kReach * (a + b);
  const double squared = std::min(foot.x * foot.x + r * r, reach * reach);
  LegAngles angles;
  angles.abduction = std::atan2(foot.y, -foot.z);
  const double cosine = std::clamp((squared - a * a - b * b) / (2 * a * b), -1.0, 1.0);
  const double sine = -std::sqrt(1 - cosine * cosine);
  angles.knee = std::atan2(sine, cosine);
  angles.hip = std::atan2(-foot.x, r) - std::atan2(b * sine, a + b * cosine);
  return angles;
}

}  // namespace cairn::actors
