#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "common/bus/messages.h"
#include "learner/harvest.h"

namespace cairn::learner {

/// LOCKSTEP's rounds that are granted and not taken yet, oldest first, with what has come in of each. A vehicle's place
/// is known from its transitions alone, so an actor that is ahead fills the next round while others still make this
/// one. Plain bookkeeping; the Coordinator locks around it.
class OpenRounds {
 public:
  explicit OpenRounds(int num_vehicles) : granted_to_(static_cast<size_t>(num_vehicles), 0) {}

  /// Every vehicle makes `steps` more steps with `policy_version`, the first `extra` vehicles one more.
  /// With `save` its harvest has the vehicles' states. Returns the number of transitions, less than steps per vehicle
  /// when some are ahead: those that made an extra step at the end of a run that now goes on.
  int64_t Grant(int steps, int extra, int64_t policy_version, bool warm_up, bool save = false);

  /// Goes on after `rounds` rounds, after which the vehicles have made `steps` transitions each.
  void Restore(int64_t rounds, std::vector<int64_t> steps);

  /// Whether all vehicles have been granted the same number of steps.
  bool level() const;

  /// Files a segment whose vehicle has made `vehicle_steps` transitions before it. False, and nothing happens, when
  /// it is not of its round's policy or goes beyond the round.
  bool Add(const Segment& segment, int64_t vehicle_steps);

  /// Files a finished episode. Actors send those of a round before its segments: it is the round its vehicle is in.
  void Add(const EpisodeResult& episode, int64_t vehicle_steps);

  /// The books of a vehicle after Add of its segment. Keeps them when that completed a round that asks for states.
  void Passed(int32_t vehicle, const VehicleState& state);

  /// Rounds taken so far, and the open ones as they were granted, without policies.
  int64_t taken() const { return newest_ - static_cast<int64_t>(rounds_.size()); }
  std::vector<RoundState> open() const;

  bool front_complete() const { return !rounds_.empty() && rounds_.front().missing == 0; }

  /// The oldest round, which must be complete, ordered by (vehicle, step): it does not depend on timing or on the
  /// number of actors.
  Harvest TakeFront();

  /// As announced to the actors.
  std::vector<Control::Round> granted() const;

  /// Transitions of all open rounds that have not come in.
  int64_t missing() const;

 private:
  struct Round {
    Control::Round grant;
    RoundState state;  // without policy
    int64_t missing = 0;
    Harvest harvest;
  };
  Round* RoundOf(int32_t vehicle, int64_t vehicle_steps);

  std::vector<int64_t> granted_to_;  // by vehicle: transitions since the run's start at the end of the newest round
  int64_t newest_ = 0;               // number of the newest granted round
  int64_t vehicle_steps_ = 0;        // granted to every vehicle in all
  std::deque<Round> rounds_;
};

}  // namespace cairn::learner
