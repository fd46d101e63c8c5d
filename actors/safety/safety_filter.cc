#include "actors/safety/safety_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "actors/command.h"

namespace cairn::actors {
namespace {

constexpr int kTries = 6;           // commands that are tried for one way of passing
constexpr int kProjections = 60;    // within the limits that they gave
constexpr double kSlack = 1e-6;     // [m] by which a rule may be missed
constexpr double kNoticed = 1e-3;   // share of a command's size that counts as a change
constexpr double kEffect = 0.7;     // of a command until the next look shows where its way is nearest to something
constexpr double kRecovery = 0.5;   // share of what is too near that a look makes up for
constexpr double kSway = 0.1;       // share of the margin by which backing off may begin with coming nearer
constexpr double kCreep = 0.6;      // share of the margin that may be used up to get free from a standstill
constexpr double kDeep = 0.8;       // share of the margin beyond which only backing off is moving
constexpr double kStands = 0.02;    // a vehicle that moves by less radii when told to stand still stands
constexpr double kLook = 1.25;      // times the way of the command …
constexpr double kLookRadii = 0.5;  // … and this many radii are looked at: others may go farther
constexpr int kHalvings = 3;        // between a command that passes and the wanted one

double Dot(const VehicleCommand& a, const VehicleCommand& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// From the outline of the footprint, negative inside; `p` in its frame. `normal` points away from the footprint.
double Distance(const Footprint& footprint, const Vector3d& p, Vector3d* normal = nullptr) {
  if (footprint.radius > 0) {
    const double norm = p.norm();
    if (normal != nullptr) *normal = norm > 0 ? Vector3d(p / norm) : Vector3d(1, 0, 0);
    return norm - footprint.radius;
  }
  const double x = std::abs(p.x()) - footprint.half_length, y = std::abs(p.y()) - footprint.half_width;
  const bool corner = x > 0 && y > 0;
  const double distance = corner ? std::sqrt(x * x + y * y) : std::max(x, y);
  if (normal == nullptr) return distance;
  const double nx = corner ? x / distance : x > y ? 1 : 0, ny = corner ? y / distance : x > y ? 0 : 1;
  *normal = Vector3d(std::copysign(nx, p.x()), std::copysign(ny, p.y()), 0);
  return distance;
}

}  // namespace

SafetyFilter::SafetyFilter(const Scene& scene)
    : vehicle_(scene.experiment().vehicle),
      config_(scene.experiment().safety),
      footprint_(scene.footprint()),
      twin_(scene.experiment()),
      surroundings_(scene.experiment()),
      num_commands_(vehicle_.action_size()),
      has_lane_(footprint_.radius == 0 && !vehicle_.holonomic() && vehicle_.min_speed >= 0 &&
                vehicle_.kind != VehicleConfig::Kind::kAckermann),
      radius_(footprint_.circumscribed_radius()),
      effect_(kEffect * twin_.stretch() * config_.period),
      lane_room_(radius_ + config_.margin) {
  const auto ranges = vehicle_.command_ranges();
  for (size_t i = 0; i < sizes_.size(); ++i) sizes_[i] = std::max(std::abs(ranges[i].min), std::abs(ranges[i].max));
}

double SafetyFilter::Slack(const Place& place, const Sighting& sighting) const {
  return Distance(footprint_, place.ToLocal(sighting.p - place.p)) - sighting.unseen;
}

// How much nearer each command brings the footprint at `place` to what was seen, all commands at their largest size:
// the velocity of its nearest point is that of the centre plus yaw rate × lever.
VehicleCommand SafetyFilter::Rates(const Place& place, const Sighting& sighting, double steering) const {
  const Vector3d local = place.ToLocal(sighting.p - place.p);
  Vector3d normal;
  const double distance = Distance(footprint_, local, &normal);
  const Vector3d n = place.FromLocal(normal), lever = place.FromLocal(local - distance * normal);
  const double turn = n.y() * lever.x() - n.x() * lever.y();
  VehicleCommand rates{n.x(), turn, 0};
  if (vehicle_.kind == VehicleConfig::Kind::kQuadrotor) rates = {n.x(), n.y(), n.z()};
  if (vehicle_.kind == VehicleConfig::Kind::kHolonomic) rates = {n.x(), n.y(), turn};
  if (vehicle_.kind == VehicleConfig::Kind::kAckermann) {  // its speed alone: the centre drifts sideways, too
    const double yaw_rate = std::tan(steering) / vehicle_.wheel_base;
    rates = {n.x() + 0.5 * vehicle_.wheel_base * yaw_rate * n.y() + yaw_rate * turn, 0, 0};
  }
  for (size_t i = 0; i < rates.size(); ++i) rates[i] *= effect_ * sizes_[i];
  return rates;
}

void SafetyFilter::Break(double excess, const VehicleCommand& rates, Verdict* verdict) const {
  if (excess <= std::max(kSlack, verdict->excess)) return;
  verdict->excess = excess;
  verdict->rates = rates;
}

// From place to place by as much as is free at least, so that most sightings are looked at once or twice.
void SafetyFilter::KeepClear(const std::vector<Place>& path, double floor, double steering, Verdict* verdict) const {
  const auto farther = [](const Place& place, double swept) { return place.swept < swept; };
  const Place* place = nullptr;
  const Sighting* nearest = nullptr;
  double least = floor;
  for (size_t i = 0; i < sightings_.size(); ++i) {
    double slack = slacks_[i];
    auto at = path.begin();
    while (true) {
      at = std::lower_bound(at + 1, path.end(), at->swept + slack - least, farther);
      if (at == path.end()) break;
      slack = Slack(*at, sightings_[i]);
      if (slack >= least) continue;
      least = slack;
      place = &*at;
      nearest = &sightings_[i];
    }
  }
  verdict->slack = least;
  if (nearest != nullptr) Break(floor - least, Rates(*place, *nearest, steering), verdict);
}

void SafetyFilter::BackOff(const std::vector<Place>& path, double steering, Verdict* verdict) const {
  const double wanted = (1 - kRecovery) * now_;
  const Place& stop = path.back();
  for (size_t i = 0; i < sightings_.size(); ++i) {
    if (slacks_[i] - stop.swept >= wanted) continue;
    const double excess = wanted - Slack(stop, sightings_[i]);
    if (excess > verdict->excess) Break(excess, Rates(stop, sightings_[i], steering), verdict);
  }
}

// A long vehicle that cannot reverse must be able to turn where it stops, or it stands there for good: it keeps what is
// straight ahead out of the circle that its corners draw.
void SafetyFilter::KeepLane(const Place& stop, Verdict* verdict) const {
  for (const Sighting& sighting : sightings_) {
    const Vector3d local = stop.ToLocal(sighting.p - stop.p);
    if (local.x() <= 0 || std::abs(local.y()) > footprint_.half_width + config_.margin) continue;
    Break(lane_room_ + sighting.unseen - local.x(), {effect_ * sizes_[0], 0, 0}, verdict);
  }
}

SafetyFilter::Verdict SafetyFilter::Judge(const VehicleCommand& shares, const std::vector<Place>& path,
                                          const Rules& rules) {
  const double steering = shares[1] * sizes_[1];
  Verdict verdict;
  KeepClear(path, rules.floor, steering, &verdict);
  if (path.back().swept > seen_) {
    VehicleCommand rates = shares;
    for (double& rate : rates) rate *= effect_ * sizes_[0];
    Break(path.back().swept - seen_, rates, &verdict);
  }
  if (rules.backs_off && now_ < 0) BackOff(path, steering, &verdict);
  if (rules.keeps_lane && has_lane_ && shares[0] > kNoticed) KeepLane(path.back(), &verdict);
  if (verdict.slack > best_slack_) {
    best_slack_ = verdict.slack;
    best_ = shares;
  }
  return verdict;
}

SafetyFilter::Verdict SafetyFilter::Judge(const VehicleCommand& shares, const Rules& rules) {
  return Judge(shares, twin_.Drive(ToUnits(shares)), rules);
}

void SafetyFilter::Clamp(VehicleCommand* command) const {
  const auto ranges = vehicle_.command_ranges();
  for (int i = 0; i < num_commands_; ++i) {
    (*command)[i] = std::clamp((*command)[i], ranges[i].min / sizes_[i], ranges[i].max / sizes_[i]);
  }
}

VehicleCommand SafetyFilter::ToUnits(const VehicleCommand& shares) const {
  VehicleCommand command{};
  for (int i = 0; i < num_commands_; ++i) command[i] = shares[i] * sizes_[i];
  return command;
}

// Onto the limit that is broken most, again and again: near the nearest command within all limits, and cheap.
VehicleCommand SafetyFilter::WithinLimits(const VehicleCommand& wanted) const {
  VehicleCommand command = wanted;
  for (int i = 0; i < kProjections; ++i) {
    const Limit* worst = nullptr;
    double most = kSlack;
    for (const Limit& limit : limits_) {
      const double excess = Dot(limit.rates, command) - limit.bound;
      if (excess <= most) continue;
      most = excess;
      worst = &limit;
    }
    if (worst == nullptr) break;
    const double squared = Dot(worst->rates, worst->rates);
    if (squared < 1e-18) break;
    for (size_t k = 0; k < command.size(); ++k) command[k] -= most / squared * worst->rates[k];
    Clamp(&command);
  }
  return command;
}

// A command near `wanted`, which breaks a rule, that passes. What one breaks is a limit for the next.
std::optional<VehicleCommand> SafetyFilter::Near(const VehicleCommand& wanted, const Rules& rules) {
  limits_.clear();
  VehicleCommand command = wanted;
  for (int i = 0; i < kTries; ++i) {
    const Verdict verdict = Judge(command, rules);
    if (verdict.excess == 0) return i == 0 ? command : Refine(command, wanted, rules);
    limits_.push_back({verdict.rates, Dot(verdict.rates, command) - verdict.excess - kSlack});
    const VehicleCommand next = WithinLimits(wanted);
    if (next == command) break;
    command = next;
  }
  return std::nullopt;
}

// Limits are straight, ways are not: on the line between the two, towards the one that breaks a rule.
VehicleCommand SafetyFilter::Refine(VehicleCommand passes, VehicleCommand breaks, const Rules& rules) {
  for (int i = 0; i < kHalvings; ++i) {
    VehicleCommand middle;
    for (size_t k = 0; k < middle.size(); ++k) middle[k] = 0.5 * (passes[k] + breaks[k]);
    (Judge(middle, rules).excess == 0 ? passes : breaks) = middle;
  }
  return passes;
}

// On its way out a vehicle may sway a little, as a quadrotor does that tilts first.
SafetyFilter::Rules SafetyFilter::BackingOff() const {
  return {now_ < 0 ? now_ - kSway * config_.margin : 0, true, true};
}

std::optional<VehicleCommand> SafetyFilter::Redirect(const VehicleCommand& wanted, Rules rules) {
  const std::optional<VehicleCommand> found = Near(wanted, rules);
  if (found || !has_lane_) return found;
  rules.keeps_lane = false;
  return Near({0, wanted[1], 0}, rules);
}

// Backing off from what is too near; coming no nearer to it, but not from deep in the margin (what is nearest is seen
// anew at each look, and many small moves come nearer by what that differs: one of 100 episodes of random commands
// touched); using up some of the margin from a standstill (parallel to a wall a car's rear swings out before its way
// leads off); standing still; and where even that comes nearer, what does so least.
VehicleCommand SafetyFilter::Find(const VehicleCommand& wanted) {
  VehicleCommand rest = twin_.Rest();
  for (int i = 0; i < num_commands_; ++i) rest[i] /= sizes_[i];
  Clamp(&rest);
  const std::vector<Place>& path = twin_.Drive(ToUnits(rest));
  const bool stands = path.back().swept < kStands * radius_;
  const bool stops = Judge(rest, path, {now_, false, false}).excess == 0;
  if (const auto found = Redirect(wanted, BackingOff())) return *found;
  if (now_ < 0 && now_ > -kDeep * config_.margin) {
    if (const auto found = Redirect(wanted, {now_, true, false})) return *found;
  }
  const double creep = -kCreep * config_.margin;
  if (stands && now_ > creep) {
    if (const auto found = Redirect(wanted, {creep, true, false})) return *found;
  }
  return stops ? rest : best_;
}

// The margin counts as unseen.
void SafetyFilter::Look(const Motion& motion, double reach, RangeFinder& ranges) {
  surroundings_.Look(motion, reach, ranges);
  sightings_ = surroundings_.sightings();
  slacks_.clear();
  now_ = 0;
  for (Sighting& sighting : sightings_) {
    sighting.unseen += config_.margin;
    slacks_.push_back(Slack(Place{}, sighting));
    now_ = std::min(now_, slacks_.back());
  }
  best_slack_ = -std::numeric_limits<double>::infinity();
}

// The twin knows the vehicle, so what it did not expect is a disturbance, and may stay for a while.
void SafetyFilter::Observe(const FilterInput& now) {
  if (now.step == drift_.step) {
    drift_.yaw_rate += now.motion.yaw_rate - drift_.expected;
    drift_.yaw_rate = std::clamp(drift_.yaw_rate, -vehicle_.max_yaw_rate, vehicle_.max_yaw_rate);
  } else {
    drift_.yaw_rate = 0;
  }
  twin_.Follow(now.vehicle, drift_.yaw_rate);
}

VehicleCommand SafetyFilter::Filter(const FilterInput& now, RangeFinder& ranges) {
  const std::vector<Place>& path = twin_.Drive(now.command);
  seen_ = kLook * path.back().swept + kLookRadii * radius_;
  const double reach = (lane_room_ + config_.margin + seen_) / (1 - surroundings_.unseen_share());
  if (now.clearance > reach) return now.command;
  Look(now.motion, reach, ranges);
  VehicleCommand wanted{};
  for (int i = 0; i < num_commands_; ++i) wanted[i] = now.command[i] / sizes_[i];
  if (Judge(wanted, path, BackingOff()).excess == 0) return now.command;
  const VehicleCommand shares = Find(wanted);
  for (int i = 0; i < num_commands_; ++i) changed_ = changed_ || std::abs(shares[i] - wanted[i]) > kNoticed;
  return changed_ ? ToUnits(shares) : now.command;
}

VehicleCommand SafetyFilter::Apply(const FilterInput& now, RangeFinder& ranges) {
  changed_ = false;
  Observe(now);
  const VehicleCommand command = Filter(now, ranges);
  if (twin_.drifts()) drift_ = {drift_.yaw_rate, twin_.YawRateAfter(command), now.step + twin_.period()};
  return command;
}

}  // namespace cairn::actors
