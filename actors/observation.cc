#include "actors/observation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cairn::actors {
namespace {

constexpr float kUnreachableEntry = 1.2f;  // where D_min is infinite, beyond all finite values

// Turns a vector of W into the level frame with this yaw.
Vector3d ToBody(const Vector3d& v, double c, double s) { return {c * v.x() + s * v.y(), c * v.y() - s * v.x(), v.z()}; }

}  // namespace

double BeamAngle(const ScanConfig& scan, int beam) {
  if (scan.beams == 1) return 0;
  const bool circle = scan.field_of_view > 2 * std::numbers::pi - 1e-6;
  if (circle) return 2 * std::numbers::pi * beam / scan.beams;
  return scan.field_of_view * (static_cast<double>(beam) / (scan.beams - 1) - 0.5);
}

std::vector<Vector3d> BeamDirections(const ScanConfig& scan, int dimension) {
  std::vector<Vector3d> beams;
  if (dimension == 2) {
    for (int beam = 0; beam < scan.beams; ++beam) {
      const double angle = BeamAngle(scan, beam);
      beams.emplace_back(std::cos(angle), std::sin(angle), 0);
    }
    return beams;
  }
  for (const int axes : {1, 3, 2}) {  // non-zero components: axes, diagonals of the cube, diagonals of its faces
    for (int i = 0; i < 27; ++i) {
      const Vector3d v(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      if (std::lround(v.squaredNorm()) == axes) beams.push_back(v.normalized());
    }
  }
  beams.resize(std::min(beams.size(), static_cast<size_t>(scan.beams)));
  return beams;
}

ObservationBuilder::ObservationBuilder(const Scene& scene)
    : scene_(scene),
      config_(scene.experiment().observation),
      vehicle_(scene.experiment().vehicle),
      beams_(BeamDirections(vehicle_.scan, vehicle_.dimension())),
      nearest_ray_(std::min(vehicle_.inscribed_radius(), vehicle_.scan.range)),
      radius_(vehicle_.circumscribed_radius()),
      size_(ObservationSize(scene.experiment())) {}

void ObservationBuilder::Build(const Motion& motion, float d_min, float* out) const {
  RangeFinder ranges(scene_);
  const std::vector<float> no_actions(static_cast<size_t>(config_.last_actions) * vehicle_.action_size());
  Build(motion, motion.pose(), d_min, ranges, no_actions, out);
}

void ObservationBuilder::Build(const Motion& motion, const Pose& believed, float d_min, RangeFinder& ranges,
                               std::span<const float> last_actions, float* out) const {
  if (config_.position) out = Position(believed, out);
  if (config_.heading && vehicle_.turns()) out = Heading(believed, out);
  if (config_.velocity) out = Velocity(motion, out);
  if (config_.d_min) out = DMin(d_min, out);
  if (config_.look_ahead) out = LookAhead(believed, out);
  if (config_.rays) out = Rays(motion, ranges, out);
  std::copy(last_actions.begin(), last_actions.end(), out);
}

float* ObservationBuilder::Position(const Pose& pose, float* out) const {
  const Box& bounds = scene_.world().bounds;
  const Vector3d p(pose.x, pose.y, pose.z);
  for (int k = 0; k < vehicle_.dimension(); ++k) {
    *out++ = static_cast<float>(2 * (p[k] - bounds.min[k]) / bounds.size()[k] - 1);
  }
  return out;
}

float* ObservationBuilder::Heading(const Pose& pose, float* out) const {
  *out++ = static_cast<float>(std::cos(pose.yaw));
  *out++ = static_cast<float>(std::sin(pose.yaw));
  return out;
}

float* ObservationBuilder::Velocity(const Motion& motion, float* out) const {
  const double top_speed = std::max(std::abs(vehicle_.min_speed), std::abs(vehicle_.max_speed));
  *out++ = static_cast<float>(motion.vx / top_speed);
  if (vehicle_.holonomic()) *out++ = static_cast<float>(motion.vy / top_speed);
  *out++ = static_cast<float>(vehicle_.turns() ? motion.yaw_rate / vehicle_.top_yaw_rate() : motion.vz / top_speed);
  return out;
}

float* ObservationBuilder::DMin(float d_min, float* out) const {
  const float entry = static_cast<float>(2 * d_min / scene_.d_min_scale() - 1);
  *out++ = std::isfinite(d_min) ? std::min(entry, kUnreachableEntry) : kUnreachableEntry;
  return out;
}

// (PointAlong(p, entry, L) − p) in the body frame over L, for L = near and far; 0 where no vertex leads to the goal.
float* ObservationBuilder::LookAhead(const Pose& pose, float* out) const {
  const Vector3d p(pose.x, pose.y, pose.z);
  const RoadmapLookup& lookup = scene_.lookup();
  const int entry = lookup.EntryVertex(p, scene_.known_field(), config_.look_ahead_clearance);
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  for (const double length : {config_.look_ahead_near, config_.look_ahead_far}) {
    const Vector3d gap = entry < 0 ? Vector3d::Zero() : Vector3d(lookup.PointAlong(p, entry, length) - p);
    const Vector3d ahead = ToBody(gap, c, s);
    for (int k = 0; k < vehicle_.dimension(); ++k) *out++ = static_cast<float>(ahead[k] / length);
  }
  return out;
}

// 1 − 2 exp(−(range − radius) / ray_scale): −1 where an obstacle touches the footprint's circle, towards 1 far away.
// A wall beside a long vehicle stands inside that circle without a collision: entries go below −1 there, down to what
// the inscribed radius gives.
float* ObservationBuilder::Rays(const Motion& motion, RangeFinder& ranges, float* out) const {
  const double c = std::cos(motion.yaw), s = std::sin(motion.yaw);
  const double x = motion.x + c * vehicle_.scan.mount_x, y = motion.y + s * vehicle_.scan.mount_x;
  const double max_range = vehicle_.scan.range;
  for (const Vector3d& beam : beams_) {
    const double dx = c * beam.x() - s * beam.y(), dy = s * beam.x() + c * beam.y();
    const double range = ranges.Range({x, y, motion.z}, {dx, dy, beam.z()}, max_range);
    const double gap = std::max(range, nearest_ray_) - radius_;
    *out++ = static_cast<float>(1 - 2 * std::exp(-gap / config_.ray_scale));
  }
  return out;
}

}  // namespace cairn::actors
