#include "actors/safety/safety_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace cairn::actors {
namespace {

constexpr int kProjections = 60;
constexpr double kSlack = 1e-3;    // of top speed, by which a limit may be missed
constexpr double kNoticed = 1e-3;  // share of a command's size that counts as a change

// Spread evenly: around the circle, in space along a spiral on the sphere (Fibonacci lattice).
std::vector<Vector3d> MakeBeams(int count, int dimension) {
  std::vector<Vector3d> beams;
  for (int i = 0; i < count; ++i) {
    if (dimension == 2) {
      const double angle = 2 * std::numbers::pi * i / count;
      beams.emplace_back(std::cos(angle), std::sin(angle), 0);
    } else {
      const double z = 1 - (2.0 * i + 1) / count, angle = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
      const double level = std::sqrt(1 - z * z);
      beams.emplace_back(level * std::cos(angle), level * std::sin(angle), z);
    }
  }
  return beams;
}

// Beams next to each beam: two on each side; on the sphere those within about twice the spacing.
std::vector<std::vector<int32_t>> Neighbours(const std::vector<Vector3d>& beams, int dimension) {
  const auto count = static_cast<double>(beams.size());
  const double reach =
      dimension == 2 ? 2.5 * 2 * std::numbers::pi / count : 2 * std::sqrt(4 * std::numbers::pi / count);
  std::vector<std::vector<int32_t>> neighbours(beams.size());
  for (size_t i = 0; i < beams.size(); ++i) {
    for (size_t j = 0; j < beams.size(); ++j) {
      if (i != j && beams[i].dot(beams[j]) > std::cos(reach)) neighbours[i].push_back(static_cast<int32_t>(j));
    }
  }
  return neighbours;
}

// The farthest that a direction can be from a beam: half a gap; on the sphere about that of a lattice of count caps.
double HalfSpacing(int count, int dimension) {
  return dimension == 2 ? std::numbers::pi / count : 1.2 * std::sqrt(4.0 / count);
}

double Dot(const VehicleCommand& a, const VehicleCommand& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

SafetyFilter::SafetyFilter(const Scene& scene, std::shared_ptr<const BrakingTable> braking)
    : vehicle_(scene.experiment().vehicle),
      config_(scene.experiment().safety),
      braking_(std::move(braking)),
      footprint_(scene.footprint()),
      period_(
          std::max(1, static_cast<int>(std::lround(config_.period * scene.experiment().environment.physics_rate_hz)))),
      num_commands_(vehicle_.action_size()),
      beams_(MakeBeams(config_.beams, vehicle_.dimension())),
      neighbours_(Neighbours(beams_, vehicle_.dimension())),
      returns_(beams_.size()),
      half_spacing_(HalfSpacing(config_.beams, vehicle_.dimension())),
      slack_(kSlack * vehicle_.max_speed),
      range_((footprint_.circumscribed_radius() + config_.margin + braking_->reach()) / (1 - half_spacing_)) {
  const auto ranges = vehicle_.command_ranges();
  for (size_t i = 0; i < sizes_.size(); ++i) sizes_[i] = std::max(std::abs(ranges[i].min), std::abs(ranges[i].max));
}

// Point of the footprint that is nearest to a point, both in the vehicle's frame.
Vector3d SafetyFilter::NearestOfFootprint(const Vector3d& point) const {
  if (footprint_.radius > 0) return point * (std::min(footprint_.radius, point.norm()) / point.norm());
  return {std::clamp(point.x(), -footprint_.half_length, footprint_.half_length),
          std::clamp(point.y(), -footprint_.half_width, footprint_.half_width), 0};
}

// Speed along `normal` of the footprint's point `nearest`, for each command at 1: its velocity is that of the centre
// plus yaw rate × lever.
VehicleCommand SafetyFilter::Rates(const Vector3d& n, const Vector3d& nearest, double steering) const {
  const double turn = n.y() * nearest.x() - n.x() * nearest.y();
  switch (vehicle_.kind) {
    case VehicleConfig::Kind::kQuadrotor:
      return {n.x(), n.y(), n.z()};
    case VehicleConfig::Kind::kHolonomic:
      return {n.x(), n.y(), turn};
    case VehicleConfig::Kind::kAckermann: {  // by its speed alone: the centre drifts sideways by half the wheel base
      const double yaw_rate = std::tan(steering) / vehicle_.wheel_base;
      return {n.x() + 0.5 * vehicle_.wheel_base * yaw_rate * n.y() + yaw_rate * turn, 0, 0};
    }
    case VehicleConfig::Kind::kWheeledCar:
    case VehicleConfig::Kind::kPlaneCar:
    case VehicleConfig::Kind::kQuadruped:
      break;
  }
  return {n.x(), turn, 0};
}

// Of the limits that ask for backing off only the most pressing one does; the others allow no coming nearer.
void SafetyFilter::Add(const VehicleCommand& rates, double bound) {
  if (std::isinf(bound)) return;
  Limit limit{rates, bound};
  for (size_t i = 0; i < sizes_.size(); ++i) limit.rates[i] *= sizes_[i];
  if (bound < backing_off_.bound) backing_off_ = limit;
  limit.bound = std::max(bound, 0.0);
  limits_.push_back(limit);
}

// A beam stands for everything between it and its neighbours, so what it hit may be nearer by range · half spacing.
SafetyFilter::Return SafetyFilter::Measure(const Vector3d& beam, double range) const {
  Return hit;
  if (range >= range_) return hit;
  hit.point = std::max(range, 1e-6) * beam;
  hit.nearest = NearestOfFootprint(hit.point);
  hit.normal = hit.point - hit.nearest;
  const double distance = hit.normal.norm();
  hit.normal = distance > 1e-9 ? Vector3d(hit.normal / distance) : beam;
  hit.lost = range * half_spacing_ + config_.margin;
  hit.gap = distance - hit.lost;
  return hit;
}

// The nearest point of each surface speaks for it: its other points come nearer in passing, and never that near.
bool SafetyFilter::IsNearestOfSurface(size_t beam) const {
  const auto& around = neighbours_[beam];
  return std::all_of(around.begin(), around.end(),
                     [&](int32_t other) { return returns_[beam].gap <= returns_[static_cast<size_t>(other)].gap; });
}

// What approaches faster than it may is told to go the other way by as much: it brakes harder, and a disturbance that
// turns a standing car into a wall is met.
void SafetyFilter::AddSurface(const Return& hit, const Motion& motion) {
  double bound = braking_->AllowedSpeed(hit.gap);
  const Vector3d velocity(motion.vx - motion.yaw_rate * hit.nearest.y(), motion.vy + motion.yaw_rate * hit.nearest.x(),
                          motion.vz);
  const double excess = hit.normal.dot(velocity) - std::max(bound, 0.0);
  if (excess > 0) bound -= excess;
  Add(Rates(hit.normal, hit.nearest, steering_), bound);
}

// A long vehicle that cannot reverse must be able to turn where it stops, or it stands there for good: it keeps what is
// straight ahead out of the circle that its corners draw.
void SafetyFilter::AddLane(const Return& hit) {
  const bool turns_in_place = vehicle_.turns() && vehicle_.kind != VehicleConfig::Kind::kAckermann;
  if (footprint_.radius > 0 || !turns_in_place || vehicle_.min_speed < 0) return;
  if (hit.point.x() <= 0 || std::abs(hit.point.y()) > footprint_.half_width + config_.margin) return;
  const double gap = hit.point.x() - footprint_.circumscribed_radius() - hit.lost;
  Add({1, 0, 0}, std::max(0.0, braking_->AllowedSpeed(gap)));
}

void SafetyFilter::Clamp(VehicleCommand* command) const {
  const auto ranges = vehicle_.command_ranges();
  for (int i = 0; i < num_commands_; ++i) {
    (*command)[i] = std::clamp((*command)[i], ranges[i].min / sizes_[i], ranges[i].max / sizes_[i]);
  }
}

const SafetyFilter::Limit* SafetyFilter::MostBroken(const VehicleCommand& command, bool back_off) const {
  const Limit* worst = nullptr;
  double most = slack_;
  const auto look = [&](const Limit& limit) {
    const double excess = Dot(limit.rates, command) - limit.bound;
    if (excess <= most) return;
    most = excess;
    worst = &limit;
  };
  for (const Limit& limit : limits_) look(limit);
  if (back_off && backing_off_.bound < 0) look(backing_off_);
  return worst;
}

// Onto the limit that is broken most, again and again: near the nearest command within all limits, and cheap. False
// when one is left.
bool SafetyFilter::Project(bool back_off, VehicleCommand* command) const {
  for (int i = 0; i < kProjections; ++i) {
    const Limit* worst = MostBroken(*command, back_off);
    if (worst == nullptr) return true;
    const double squared = Dot(worst->rates, worst->rates);
    if (squared < 1e-18) return false;
    const double excess = Dot(worst->rates, *command) - worst->bound;
    for (size_t k = 0; k < command->size(); ++k) (*command)[k] -= excess / squared * worst->rates[k];
    Clamp(command);
  }
  return false;
}

// Along the line to standing still, which no limit forbids.
void SafetyFilter::Scale(VehicleCommand* command) const {
  double scale = 1;
  for (const Limit& limit : limits_) {
    const double rate = Dot(limit.rates, *command);
    if (rate > limit.bound + slack_) scale = std::min(scale, limit.bound / rate);
  }
  for (double& value : *command) value *= scale;
  Clamp(command);
}

VehicleCommand SafetyFilter::Apply(const VehicleCommand& command, const Motion& motion, double clearance,
                                   RangeFinder& ranges) {
  changed_ = false;
  if (clearance > range_) return command;
  limits_.clear();
  backing_off_.bound = 0;
  steering_ = vehicle_.kind == VehicleConfig::Kind::kAckermann ? command[1] : 0;
  const double c = std::cos(motion.yaw), s = std::sin(motion.yaw);
  const Vector3d center(motion.x, motion.y, motion.z);
  for (size_t i = 0; i < beams_.size(); ++i) {
    const Vector3d& beam = beams_[i];
    const Vector3d direction(c * beam.x() - s * beam.y(), s * beam.x() + c * beam.y(), beam.z());
    returns_[i] = Measure(beam, ranges.Range(center, direction, range_));
  }
  for (size_t i = 0; i < beams_.size(); ++i) {
    if (std::isinf(returns_[i].gap)) continue;
    if (IsNearestOfSurface(i)) AddSurface(returns_[i], motion);
    AddLane(returns_[i]);
  }
  VehicleCommand shares{};
  for (int i = 0; i < num_commands_; ++i) shares[i] = command[i] / sizes_[i];
  const VehicleCommand wanted = shares;
  if (!Project(true, &shares)) {  // backing off from one thing may be coming nearer to another
    shares = wanted;
    if (!Project(false, &shares)) Scale(&shares);
  }
  VehicleCommand filtered = command;
  for (int i = 0; i < num_commands_; ++i) {
    changed_ = changed_ || std::abs(shares[i] - wanted[i]) > kNoticed;
    filtered[i] = shares[i] * sizes_[i];
  }
  if (vehicle_.kind == VehicleConfig::Kind::kAckermann) filtered[1] = command[1];  // its limits are about the speed
  return changed_ ? filtered : command;
}

}  // namespace cairn::actors
