#include "actors/surprise_finder.h"

#include <cmath>

#include "actors/observation.h"

namespace cairn::actors {
namespace {

// Share of a mark's radius around its middle that a ray must pass through to free it: the middle lies half a radius
// behind a surface, so that rays along the surface do not.
constexpr double kMiddle = 0.4;

}  // namespace

SurpriseFinder::SurpriseFinder(const Scene& scene)
    : scene_(scene),
      config_(scene.experiment().planner),
      vehicle_(scene.experiment().vehicle),
      beams_(BeamDirections(vehicle_.scan, vehicle_.dimension())) {}

void SurpriseFinder::LookAround(const Motion& motion, RangeFinder& ranges, Findings* findings) const {
  const bool loses = scene_.experiment().observation.range_dropout > 0;
  const double c = std::cos(motion.yaw), s = std::sin(motion.yaw);
  const Vector3d origin(motion.x + c * vehicle_.scan.mount_x, motion.y + s * vehicle_.scan.mount_x, motion.z);
  const std::vector<float>& marks = scene_.lookup().table().marks;
  std::vector<char> freed(marks.size() / 3, 0);
  for (const Vector3d& beam : beams_) {
    const Vector3d direction(c * beam.x() - s * beam.y(), s * beam.x() + c * beam.y(), beam.z());
    const double range = ranges.Range(origin, direction, vehicle_.scan.range);
    const double expected = scene_.CastKnownRay(origin, direction, vehicle_.scan.range + config_.repair_margin);
    if (range < vehicle_.scan.range && range < expected - config_.repair_margin) {
      findings->found.push_back(origin + (range + 0.5 * config_.repair_mark_radius) * direction);
    }
    if (loses && range >= vehicle_.scan.range) continue;
    for (size_t m = 0; m < freed.size(); ++m) {
      const Vector3d mark(marks[3 * m], marks[3 * m + 1], marks[3 * m + 2]);
      if (SeesThrough(mark, origin, direction, range)) freed[m] = 1;
    }
  }
  for (size_t m = 0; m < freed.size(); ++m) {
    if (freed[m]) findings->freed.emplace_back(marks[3 * m], marks[3 * m + 1], marks[3 * m + 2]);
  }
}

bool SurpriseFinder::SeesThrough(const Vector3d& mark, const Vector3d& origin, const Vector3d& direction,
                                 double range) const {
  const double at = (mark - origin).dot(direction);
  const bool behind = at > 0 && range > at + config_.repair_mark_radius;
  return behind && (origin + at * direction - mark).norm() < kMiddle * config_.repair_mark_radius;
}

void SurpriseFinder::Touch(const Motion& motion, Findings* findings) const {
  if (scene_.TouchesKnown(motion)) return;
  const double c = std::cos(motion.yaw), s = std::sin(motion.yaw);
  Vector3d way(c * motion.vx - s * motion.vy, s * motion.vx + c * motion.vy, motion.vz);
  if (way.norm() < 1e-6) way = Vector3d(c, s, 0);
  findings->found.push_back(Vector3d(motion.x, motion.y, motion.z) +
                            vehicle_.circumscribed_radius() * way.normalized());
}

}  // namespace cairn::actors
