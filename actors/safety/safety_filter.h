#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "actors/motion.h"
#include "actors/range_finder.h"
#include "actors/safety/braking.h"
#include "actors/scene.h"

namespace cairn::actors {

/// The paper's distance-based safety filter, without a model of the world and for every kind of vehicle: the nearest
/// return of each surface that a dense scan sees is a point that the footprint may approach no faster than the vehicle
/// can brake for (a velocity damper, Faverjon & Tournassoud 1987). That is a linear limit on the commands; the command
/// is moved to a near one within all limits (so it slides along a wall instead of stopping before it), and what then
/// still breaks one is scaled down. Standing still is always allowed, and what is too near already is backed away from
/// where the vehicle can.
class SafetyFilter {
 public:
  /// `scene` must outlive it.
  SafetyFilter(const Scene& scene, std::shared_ptr<const BrakingTable> braking);

  /// The command that goes to the vehicle instead of `command`. `clearance` [m] from the centre to the nearest thing
  /// only saves work where nothing is near.
  VehicleCommand Apply(const VehicleCommand& command, const Motion& motion, double clearance, RangeFinder& ranges);

  /// Whether the last Apply changed the command by more than a thousandth of its range.
  bool changed() const { return changed_; }

  /// Physics steps between two looks.
  int period() const { return period_; }

 private:
  // rates · command ≤ limit, commands as shares of their largest size.
  struct Limit {
    VehicleCommand rates{};
    double bound = 0;
  };
  // What a beam hit, in the level frame that turns with the vehicle.
  struct Return {
    Vector3d point = Vector3d::Zero();
    Vector3d nearest = Vector3d::Zero();  // point of the footprint
    Vector3d normal = Vector3d::Zero();   // from there to the point
    double lost = 0;                      // of the distance: margin, and what is unseen between beams [m]
    double gap = std::numeric_limits<double>::infinity();  // [m]
  };
  Return Measure(const Vector3d& beam, double range) const;
  bool IsNearestOfSurface(size_t beam) const;
  void AddSurface(const Return& hit, const Motion& motion);
  void AddLane(const Return& hit);
  void Add(const VehicleCommand& rates, double bound);
  VehicleCommand Rates(const Vector3d& normal, const Vector3d& nearest, double steering) const;
  Vector3d NearestOfFootprint(const Vector3d& point) const;
  const Limit* MostBroken(const VehicleCommand& command, bool back_off) const;
  bool Project(bool back_off, VehicleCommand* command) const;
  void Clamp(VehicleCommand* command) const;
  void Scale(VehicleCommand* command) const;

  const VehicleConfig& vehicle_;
  const SafetyConfig& config_;
  std::shared_ptr<const BrakingTable> braking_;
  Footprint footprint_;
  int period_;
  int num_commands_;
  VehicleCommand sizes_{};                        // largest size of each command
  std::vector<Vector3d> beams_;                   // unit vectors in the level frame that turns with the vehicle
  std::vector<std::vector<int32_t>> neighbours_;  // of each beam
  std::vector<Return> returns_;                   // of the last look
  double half_spacing_;                           // between neighbouring beams [rad]
  double slack_;                                  // of a limit [m/s]
  double range_;                                  // of the scan [m]
  double steering_ = 0;                           // of the command that is filtered
  std::vector<Limit> limits_;                     // none below 0
  Limit backing_off_;                             // the lowest below 0
  bool changed_ = false;
};

}  // namespace cairn::actors
