#pragma once

#include <vector>

#include "actors/blob.h"
#include "actors/motion.h"
#include "actors/scene.h"
#include "common/core/random.h"

namespace cairn::actors {

/// People who walk to and fro along the way that the roadmap gives from the vehicle's start to the goal
/// (world.persons): upright cylinders that nobody was told of. They wait instead of walking into the vehicle, so a
/// collision with one is the vehicle's doing.
class Persons {
 public:
  /// `scene` must outlive it.
  explicit Persons(const Scene& scene);

  /// Starts an episode: each begins somewhere on the way, four vehicle radii and its own from the start at least, and
  /// walks one way or the other, from end to end. A way too short for that has none; so has `present` = false.
  void Reset(const Vector3d& start, bool present, RandomStream random);

  /// Walks for `time` [s] past a vehicle whose centre is at `vehicle`: a person who would come nearer to it than 1.25
  /// times the circle in which it can turn stands.
  void Walk(double time, const Vector3d& vehicle);

  bool empty() const { return bodies_.empty(); }
  const std::vector<Cylinder>& bodies() const { return bodies_; }

  /// Distance from p to the nearest one [m], negative inside; infinite when there is none.
  double Distance(const Vector3d& p) const;

  /// The same from the footprint at a pose, at least 0.
  double Clearance(const Pose& pose, const Footprint& footprint) const;

  /// Distance from p along a unit vector to the first one, at most `max_range`; 0 inside.
  double CastRay(const Vector3d& p, const Vector3d& direction, double max_range) const;

  void Write(BlobWriter& blob) const;
  void Read(BlobReader& blob);

 private:
  void LayWay(const Vector3d& start);
  Vector3d PlaceAt(double s) const;
  void Stand();

  const Scene& scene_;
  const WorldConfig& config_;
  double radius_;      // the vehicle's circumscribed
  double keep_clear_;  // of the way's ends [m]
  std::vector<Vector3d> way_;
  std::vector<double> along_;   // arc length at each of its points [m]
  std::vector<double> places_;  // of each person on the way there and back, 0 to twice its length [m]
  std::vector<Cylinder> bodies_;
};

}  // namespace cairn::actors
