#include "actors/safety/surroundings.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cairn::actors {
namespace {

constexpr double kFillRadii = 0.1;
constexpr double kStraight = 0.9;  // cosine of the angle by which a straight line bends at most
constexpr double kSeen = 0.5;      // unseen of a straight line, over that of others

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

// A wall may go on past the beam that hit it, almost to the next one, which missed it, and a corner may stick out
// between two beams by about as much. In space that is as far as a direction can be from a beam, about that of a
// lattice of count caps.
double UnseenShare(int count, int dimension) {
  return dimension == 2 ? 2 * std::numbers::pi / count : 1.2 * std::sqrt(4.0 / count);
}

}  // namespace

Surroundings::Surroundings(const Experiment& experiment)
    : dimension_(experiment.vehicle.dimension()),
      beams_(MakeBeams(experiment.safety.beams, dimension_)),
      unseen_share_(UnseenShare(experiment.safety.beams, dimension_)),
      fill_(kFillRadii * experiment.vehicle.circumscribed_radius()),
      width_(2 * experiment.vehicle.inscribed_radius()) {}

// The ends are the first `hits` sightings, in the order of the beams.
void Surroundings::Measure(size_t hits) {
  const auto way = [&](size_t i) { return Vector3d(sightings_[(i + 1) % hits].p - sightings_[i].p); };
  joins_.resize(hits);
  for (size_t i = 0; i < hits; ++i) joins_[i] = way(i).norm() < width_ ? 1 : 0;
  for (size_t i = 0; i < hits; ++i) {
    const size_t before = (i + hits - 1) % hits;
    if (joins_[i] == 0 || joins_[before] == 0) continue;
    const Vector3d to = way(before), from = way(i);
    if (to.dot(from) > kStraight * to.norm() * from.norm()) sightings_[i].unseen *= kSeen;
  }
}

void Surroundings::Join(size_t hits) {
  for (size_t hit = 0; hit < hits; ++hit) {
    if (joins_[hit] == 0) continue;
    const Sighting a = sightings_[hit], b = sightings_[(hit + 1) % hits];
    const int parts = static_cast<int>((b.p - a.p).norm() / fill_) + 1;
    for (int i = 1; i < parts; ++i) {
      sightings_.push_back({a.p + static_cast<double>(i) / parts * (b.p - a.p), std::max(a.unseen, b.unseen)});
    }
  }
}

void Surroundings::Look(const Motion& motion, double reach, RangeFinder& ranges) {
  sightings_.clear();
  const double c = std::cos(motion.yaw), s = std::sin(motion.yaw);
  const Vector3d center(motion.x, motion.y, motion.z);
  for (const Vector3d& beam : beams_) {
    const Vector3d direction(c * beam.x() - s * beam.y(), s * beam.x() + c * beam.y(), beam.z());
    const double range = ranges.Range(center, direction, reach);
    if (range < reach) sightings_.push_back({range * beam, range * unseen_share_});
  }
  if (dimension_ == 3) return;
  const size_t hits = sightings_.size();
  Measure(hits);
  Join(hits);
}

}  // namespace cairn::actors
