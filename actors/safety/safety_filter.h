#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "actors/blob.h"
#include "actors/motion.h"
#include "actors/range_finder.h"
#include "actors/safety/braking.h"
#include "actors/safety/surroundings.h"
#include "actors/scene.h"

namespace cairn::actors {

/// A command at a look, and the vehicle that it is for.
struct FilterInput {
  const VehicleCommand& command;
  const Vehicle& vehicle;
  const Motion& motion;  ///< where it is
  double clearance;      ///< from its centre to the nearest thing [m]; only saves work where nothing is near
  int64_t step;          ///< physics steps since the episode began
};

/// The paper's distance-based safety filter, without a model of the world and for every kind of vehicle. A command
/// passes when the vehicle, told so until the next look and to stand still from then on, would keep clear of all that a
/// dense scan sees. So there is a way to stop at every look, the one that let the last command pass. A command that
/// does not pass is moved to a near one that does (it slides along a wall instead of stopping before it), scaled down,
/// or exchanged for standing still. What is too near already may come no nearer, and is backed away from where the
/// vehicle can.
class SafetyFilter {
 public:
  /// Keeps nothing of `scene`.
  explicit SafetyFilter(const Scene& scene);

  /// Starts an episode.
  void Reset() { drift_ = Drift{}; }

  /// The command that goes to the vehicle instead of now.command.
  VehicleCommand Apply(const FilterInput& now, RangeFinder& ranges);

  /// Whether the last Apply changed the command by more than a thousandth of its range.
  bool changed() const { return changed_; }

  /// Physics steps between two looks.
  int period() const { return twin_.period(); }

  void Write(BlobWriter& blob) const { blob.Put(drift_); }
  void Read(BlobReader& blob) { blob.Get(drift_); }

 private:
  // Yaw rate that nobody commanded, as a held disturbance brings it, by what the last look expected.
  struct Drift {
    double yaw_rate = 0;  // [rad/s]
    double expected = 0;  // at `step` [rad/s]
    int64_t step = -1;    // [physics steps]
  };
  // rates · command ≤ bound, commands as shares of their largest size.
  struct Limit {
    VehicleCommand rates{};
    double bound = 0;
  };
  // What a command must keep to, beside coming no nearer than the margin.
  struct Rules {
    double floor = 0;        // of the slack on the way [m]
    bool keeps_lane = true;  // room to turn round
    bool backs_off = true;   // from what is too near
  };
  // What comes of a command.
  struct Verdict {
    double slack = 0;        // the least on the way [m], at most the floor
    double excess = 0;       // of the rule that is broken most [m]; 0: passes
    VehicleCommand rates{};  // of that rule, per share of the commands [m]
  };
  double Slack(const Place& place, const Sighting& sighting) const;
  VehicleCommand Rates(const Place& place, const Sighting& sighting, double steering) const;
  void Break(double excess, const VehicleCommand& rates, Verdict* verdict) const;
  void KeepClear(const std::vector<Place>& path, double floor, double steering, Verdict* verdict) const;
  void BackOff(const std::vector<Place>& path, double steering, Verdict* verdict) const;
  void KeepLane(const Place& stop, Verdict* verdict) const;
  Verdict Judge(const VehicleCommand& shares, const std::vector<Place>& path, const Rules& rules);
  Verdict Judge(const VehicleCommand& shares, const Rules& rules);
  std::optional<VehicleCommand> Near(const VehicleCommand& wanted, const Rules& rules);
  VehicleCommand Refine(VehicleCommand passes, VehicleCommand breaks, const Rules& rules);
  Rules BackingOff() const;
  std::optional<VehicleCommand> Redirect(const VehicleCommand& wanted, Rules rules);
  VehicleCommand Find(const VehicleCommand& wanted);
  void Look(const Motion& motion, double reach, RangeFinder& ranges);
  void Observe(const FilterInput& now);
  VehicleCommand Filter(const FilterInput& now, RangeFinder& ranges);
  VehicleCommand WithinLimits(const VehicleCommand& wanted) const;
  void Clamp(VehicleCommand* command) const;
  VehicleCommand ToUnits(const VehicleCommand& shares) const;

  VehicleConfig vehicle_;
  SafetyConfig config_;
  Footprint footprint_;
  BrakingTwin twin_;
  Surroundings surroundings_;
  int num_commands_;
  bool has_lane_;           // it cannot reverse, and its corners swing out where it turns
  double radius_;           // circumscribed [m]
  VehicleCommand sizes_{};  // largest size of each command
  double effect_;           // way [m] for each m/s of a command until the next look
  double lane_room_;        // of the circle of its corners [m]
  double seen_ = 0;         // swept ways [m] that the scan covers
  double now_ = 0;          // least slack where it is, at most 0 [m]
  Drift drift_;
  std::vector<Sighting> sightings_;  // unseen counts the margin too
  std::vector<double> slacks_;       // of them where it is [m]
  std::vector<Limit> limits_;
  VehicleCommand best_{};  // of those judged, by the least slack on its way
  double best_slack_ = 0;  // [m]
  bool changed_ = false;
};

}  // namespace cairn::actors
