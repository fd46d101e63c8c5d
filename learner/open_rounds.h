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
  explicit OpenRounds(int num_vehicles) : num_vehicles_(num_vehicles) {}

  /// Every vehicle makes `steps` more steps with `policy_version`, the first `extra` vehicles one more.
  void Grant(int steps, int extra, int64_t policy_version, bool warm_up);

  /// Files a segment whose vehicle has made `vehicle_steps` transitions before it. False, and nothing happens, when
  /// it is not of its round's policy or goes beyond the round.
  bool Add(const Segment& segment, int64_t vehicle_steps);

  /// Files a finished episode. Actors send those of a round before its segments: it is the round its vehicle is in.
  void Add(const EpisodeResult& episode, int64_t vehicle_steps);

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
    int64_t missing = 0;
    Harvest harvest;
  };
  Round* RoundOf(int32_t vehicle, int64_t vehicle_steps);

  int num_vehicles_;
  int64_t newest_ = 0;         // number of the newest granted round
  int64_t vehicle_steps_ = 0;  // granted to every vehicle in all
  std::deque<Round> rounds_;
};

}  // namespace cairn::learner
