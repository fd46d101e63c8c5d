#include "actors/observation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cairn::actors {
namespace {

constexpr float kUnreachableEntry = 1.2f;  // where D_min is infinite, beyond all finite values

}  // namespace

double BeamAngle(const ScanConfig& scan, int beam) {
  if (scan.beams == 1) return 0;
  const bool circle = scan.field_of_view > 2 * std::numbers::pi - 1e-6;
  if (circle) return 2 * std::numbers::pi * beam / scan.beams;
  return scan.field_of_view * (static_cast<double>(beam) / (scan.beams - 1) - 0.5);
}

ObservationBuilder::ObservationBuilder(const Scene& scene)
    : scene_(scene),
      config_(scene.experiment().observation),
      vehicle_(scene.experiment().vehicle),
      nearest_ray_(std::min(vehicle_.inscribed_radius(), vehicle_.scan.range)),
      radius_(vehicle_.circumscribed_radius()),
      size_(ObservationSize(scene.experiment())) {
  for (int beam = 0; beam < vehicle_.scan.beams; ++beam) {
    const double angle = BeamAngle(vehicle_.scan, beam);
    beams_.push_back({std::cos(angle), std::sin(angle)});
  }
}

void ObservationBuilder::Build(const GroundState& state, float d_min, float* out) const {
  if (config_.position) out = Position(state, out);
  if (config_.heading) out = Heading(state, out);
  if (config_.velocity) out = Velocity(state, out);
  if (config_.d_min) out = DMin(d_min, out);
  if (config_.look_ahead) out = LookAhead(state, out);
  if (config_.rays) Rays(state, out);
}

float* ObservationBuilder::Position(const GroundState& state, float* out) const {
  const Box& bounds = scene_.world().bounds;
  *out++ = static_cast<float>(2 * (state.x - bounds.min.x()) / bounds.size().x() - 1);
  *out++ = static_cast<float>(2 * (state.y - bounds.min.y()) / bounds.size().y() - 1);
  return out;
}

float* ObservationBuilder::Heading(const GroundState& state, float* out) const {
  *out++ = static_cast<float>(std::cos(state.yaw));
  *out++ = static_cast<float>(std::sin(state.yaw));
  return out;
}

float* ObservationBuilder::Velocity(const GroundState& state, float* out) const {
  const double top_speed = std::max(std::abs(vehicle_.min_speed), std::abs(vehicle_.max_speed));
  *out++ = static_cast<float>(state.speed / top_speed);
  *out++ = static_cast<float>(state.yaw_rate / vehicle_.max_yaw_rate);
  return out;
}

float* ObservationBuilder::DMin(float d_min, float* out) const {
  const float entry = static_cast<float>(2 * d_min / scene_.d_min_scale() - 1);
  *out++ = std::isfinite(d_min) ? std::min(entry, kUnreachableEntry) : kUnreachableEntry;
  return out;
}

// (PointAlong(p, entry, L) − p) in the body frame over L, for L = near and far; 0 where no vertex leads to the goal.
float* ObservationBuilder::LookAhead(const GroundState& state, float* out) const {
  const Vector3d p(state.x, state.y, 0);
  const RoadmapLookup& lookup = scene_.lookup();
  const int entry = lookup.EntryVertex(p, scene_.field(), config_.look_ahead_clearance);
  const double c = std::cos(state.yaw), s = std::sin(state.yaw);
  for (const double length : {config_.look_ahead_near, config_.look_ahead_far}) {
    const Vector3d gap = entry < 0 ? Vector3d::Zero() : Vector3d(lookup.PointAlong(p, entry, length) - p);
    *out++ = static_cast<float>((c * gap.x() + s * gap.y()) / length);
    *out++ = static_cast<float>((c * gap.y() - s * gap.x()) / length);
  }
  return out;
}

// 1 − 2 exp(−(range − radius) / ray_scale): −1 where an obstacle touches the footprint's circle, towards 1 far away.
// A wall beside a long vehicle stands inside that circle without a collision: entries go below −1 there, down to what
// the inscribed radius gives.
float* ObservationBuilder::Rays(const GroundState& state, float* out) const {
  const double c = std::cos(state.yaw), s = std::sin(state.yaw);
  const double x = state.x + c * vehicle_.scan.mount_x, y = state.y + s * vehicle_.scan.mount_x;
  for (const Direction& beam : beams_) {
    const double range =
        scene_.obstacles().CastRay(x, y, c * beam.x - s * beam.y, s * beam.x + c * beam.y, vehicle_.scan.range);
    const double gap = std::max(range, nearest_ray_) - radius_;
    *out++ = static_cast<float>(1 - 2 * std::exp(-gap / config_.ray_scale));
  }
  return out;
}

}  // namespace cairn::actors
