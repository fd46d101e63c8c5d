#include "actors/persons.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/world/signed_distance.h"

namespace cairn::actors {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTurningRadii = 1.25;
constexpr double kClearRadii = 4;  // between a person at its ends and the vehicle's start, or the goal

// Where the ray enters the cylinder (in the plane the disc): between the roots of |level part of p + t d − axis|² =
// radius², and between the faces. 0 when it starts inside, infinity when it misses.
double Hit(const Cylinder& c, const Vector3d& p, const Vector3d& d, int dimension) {
  double enter = -kInfinity, leave = kInfinity;
  if (dimension == 3) {
    const double inverse = 1 / (std::abs(d.z()) < 1e-300 ? 1e-300 : d.z());
    const double low = (c.base.z() - p.z()) * inverse, high = (c.base.z() + c.height - p.z()) * inverse;
    enter = std::min(low, high);
    leave = std::max(low, high);
  }
  const double px = p.x() - c.base.x(), py = p.y() - c.base.y();
  const double a = d.x() * d.x() + d.y() * d.y(), b = px * d.x() + py * d.y();
  const double inside = px * px + py * py - c.radius * c.radius;
  if (a < 1e-24) {
    if (inside > 0) return kInfinity;
  } else {
    const double discriminant = b * b - a * inside;
    if (discriminant < 0) return kInfinity;
    const double root = std::sqrt(discriminant);
    enter = std::max(enter, (-b - root) / a);
    leave = std::min(leave, (-b + root) / a);
  }
  return leave >= 0 && enter <= leave ? std::max(enter, 0.0) : kInfinity;
}

}  // namespace

Persons::Persons(const Scene& scene)
    : scene_(scene),
      config_(scene.experiment().world),
      radius_(scene.experiment().vehicle.circumscribed_radius()),
      keep_clear_(kClearRadii * radius_ + config_.person_radius) {}

// The roadmap's way from the start, less what lies near its ends.
void Persons::LayWay(const Vector3d& start) {
  way_.clear();
  along_.clear();
  const RoadmapLookup& lookup = scene_.lookup();
  const int entry = lookup.EntryVertex(start, scene_.known_field(), 0);
  if (entry < 0) return;
  const double length = (lookup.position(entry) - start).norm() + lookup.table().cost[entry];
  const double step = std::max(0.5 * radius_, length / 1000);
  for (double s = keep_clear_; s <= length - keep_clear_; s += step) {
    const Vector3d p = lookup.PointAlong(start, entry, s);
    if ((p - start).norm() < keep_clear_) continue;  // a way may come back
    along_.push_back(way_.empty() ? 0 : along_.back() + (p - way_.back()).norm());
    way_.push_back(p);
  }
}

void Persons::Reset(const Vector3d& start, bool present, RandomStream random) {
  places_.clear();
  bodies_.clear();
  if (!present || config_.persons == 0) return;
  LayWay(start);
  if (way_.empty()) return;
  for (int i = 0; i < config_.persons; ++i) places_.push_back(random.Uniform(0, 2 * along_.back()));
  Stand();
}

// Place s of the way there and back is s up to its length L, then 2 L − s.
Vector3d Persons::PlaceAt(double s) const {
  if (s > along_.back()) s = 2 * along_.back() - s;
  const auto next = static_cast<size_t>(std::upper_bound(along_.begin(), along_.end(), s) - along_.begin());
  const size_t b = std::min(next, along_.size() - 1), a = b == 0 ? 0 : b - 1;
  const double gap = along_[b] - along_[a];
  return gap > 0 ? Vector3d(way_[a] + (s - along_[a]) / gap * (way_[b] - way_[a])) : way_[b];
}

void Persons::Stand() {
  bodies_.clear();
  const double height = scene_.world().dimension == 3 ? 2 * config_.person_radius : 0;
  for (const double place : places_) {
    bodies_.push_back({PlaceAt(place) - Vector3d(0, 0, 0.5 * height), config_.person_radius, height});
  }
}

void Persons::Walk(double time, const Vector3d& vehicle) {
  const double keep = kTurningRadii * radius_ + config_.person_radius;
  for (double& place : places_) {
    if (along_.back() == 0) continue;
    const double next = std::fmod(place + config_.person_speed * time, 2 * along_.back());
    const double distance = (PlaceAt(next) - vehicle).norm();
    if (distance >= keep || distance >= (PlaceAt(place) - vehicle).norm()) place = next;
  }
  Stand();
}

double Persons::Distance(const Vector3d& p) const {
  double distance = kInfinity;
  for (const Cylinder& body : bodies_) {
    distance = std::min(distance, SignedDistance(body, p, scene_.world().dimension));
  }
  return distance;
}

double Persons::Clearance(const Pose& pose, const Footprint& footprint) const {
  if (footprint.radius > 0) return std::max(0.0, Distance({pose.x, pose.y, pose.z}) - footprint.radius);
  double clearance = kInfinity;
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  for (const Cylinder& body : bodies_) {
    const double x = body.base.x() - pose.x, y = body.base.y() - pose.y;
    const double ahead = std::max(0.0, std::abs(c * x + s * y) - footprint.half_length);
    const double aside = std::max(0.0, std::abs(c * y - s * x) - footprint.half_width);
    clearance = std::min(clearance, std::hypot(ahead, aside) - body.radius);
  }
  return std::max(0.0, clearance);
}

double Persons::CastRay(const Vector3d& p, const Vector3d& direction, double max_range) const {
  double range = max_range;
  for (const Cylinder& body : bodies_) range = std::min(range, Hit(body, p, direction, scene_.world().dimension));
  return range;
}

void Persons::Write(BlobWriter& blob) const {
  const auto put = [&](const std::vector<double>& values) {
    blob.Put(static_cast<uint64_t>(values.size()));
    for (const double value : values) blob.Put(value);
  };
  put(places_);
  if (places_.empty()) return;
  put(along_);
  for (const Vector3d& p : way_) blob.Put(std::array<double, 3>{p.x(), p.y(), p.z()});
}

void Persons::Read(BlobReader& blob) {
  const auto get = [&](std::vector<double>& values) {
    uint64_t size = 0;
    blob.Get(size);
    values.clear();
    for (uint64_t i = 0; i < size; ++i) {
      double value = 0;
      blob.Get(value);  // throws at the blob's end, whatever the size says
      values.push_back(value);
    }
  };
  get(places_);
  bodies_.clear();
  way_.clear();
  if (places_.empty()) return;
  get(along_);
  if (along_.empty()) ThrowError("environment blob: {} persons without a way", places_.size());
  for (size_t i = 0; i < along_.size(); ++i) {
    std::array<double, 3> p{};
    blob.Get(p);
    way_.emplace_back(p[0], p[1], p[2]);
  }
  Stand();
}

}  // namespace cairn::actors
