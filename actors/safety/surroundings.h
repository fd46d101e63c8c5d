#pragma once

#include <vector>

#include "actors/motion.h"
#include "actors/range_finder.h"
#include "common/config/experiment.h"

namespace cairn::actors {

/// Something that a scan sees, in the level frame of the vehicle that looked.
struct Sighting {
  Vector3d p = Vector3d::Zero();
  double unseen = 0;  ///< nothing that the beams miss is farther from a sighting than this [m]
};

/// What stands around a vehicle, by safety.beams rays from its centre: where they end, and in the plane the lines
/// between ends too near to each other for the vehicle to pass between them, as points a tenth of a radius apart. Where
/// such lines run straight on, less is unseen.
class Surroundings {
 public:
  explicit Surroundings(const Experiment& experiment);

  /// Looks as far as `reach` [m].
  void Look(const Motion& motion, double reach, RangeFinder& ranges);

  const std::vector<Sighting>& sightings() const { return sightings_; }

  /// What lies between beams is unseen by this share of its range.
  double unseen_share() const { return unseen_share_; }

 private:
  void Measure(size_t hits);
  void Join(size_t hits);

  int dimension_;
  std::vector<Vector3d> beams_;  // unit vectors in the level frame
  double unseen_share_;
  double fill_;              // between points of a line [m]
  double width_;             // no vehicle passes where less is free [m]
  std::vector<char> joins_;  // of each end: with the next one
  std::vector<Sighting> sightings_;
};

}  // namespace cairn::actors
