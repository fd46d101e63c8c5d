#pragma once

#include <vector>

#include "actors/motion.h"
#include "actors/range_finder.h"
#include "actors/scene.h"

namespace cairn::actors {

/// What a vehicle has found out about obstacles that the planner does not know [m].
struct Findings {
  std::vector<Vector3d> found;  ///< something stands here
  std::vector<Vector3d> freed;  ///< places of marks at which nothing stands
};

/// Holds what a vehicle sees and touches against what the planner knows: its world and the marks of the table.
class SurpriseFinder {
 public:
  /// `scene` must outlive it.
  explicit SurpriseFinder(const Scene& scene);

  /// Rays of the scan that end more than planner.repair_margin short of every known obstacle have found something: half
  /// a mark's radius behind where they end, so that it lies inside. Rays that pass near the middle of a mark and go on
  /// have freed it, where they end at something; where no ray can be lost (observation.range_dropout) also where they
  /// see nothing.
  void LookAround(const Motion& motion, RangeFinder& ranges, Findings* findings) const;

  /// After a contact: what was touched stands ahead in the direction of motion, unless it is known.
  void Touch(const Motion& motion, Findings* findings) const;

 private:
  bool SeesThrough(const Vector3d& mark, const Vector3d& origin, const Vector3d& direction, double range) const;

  const Scene& scene_;
  const PlannerConfig& config_;
  const VehicleConfig& vehicle_;
  std::vector<Vector3d> beams_;  // unit vectors in the body frame
};

}  // namespace cairn::actors
