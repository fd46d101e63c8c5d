#pragma once

#include <cstdint>

#include "common/core/clock.h"
#include "learner/fleet.h"

namespace cairn::learner {

/// ASYNC: who may make how many transitions. Credit is a session's total and never shrinks, so the sum of what is
/// accepted and what is granted never passes what is allowed, and a run ends exactly at its total. Plain bookkeeping;
/// the Coordinator locks around it.
class CreditLedger {
 public:
  /// What is worth handing out, in transitions.
  struct Amounts {
    int64_t enough = 0;  ///< for a frame that wakes all actors, if the last one is not too recent
    int64_t plenty = 0;  ///< for one at once
    int64_t burst = 0;   ///< for having one actor work: a few steps are made with cold caches
  };

  /// `total`: transitions of the whole run.
  CreditLedger(int64_t total, const Amounts& amounts) : total_(total), amounts_(amounts) {}

  /// Transitions that may be made so far, capped at the total; never lower than before.
  void Allow(int64_t allowed);

  /// A session is gone after this many accepted transitions: what it had not used is free again.
  void Retire(int64_t accepted) { retired_ += accepted; }

  /// Hands out what is free, to those first that have least left of what they were given, so that one that hangs does
  /// not gather it all; actors that are faster than credit comes get bursts in turn. Unless there is plenty it waits
  /// until `interval` has passed since the last time, and until there is enough or `patience` has passed. True when
  /// anybody got any.
  bool Distribute(Fleet* fleet, Duration interval, Duration patience, TimePoint now);

 private:
  int64_t total_;
  Amounts amounts_;
  int64_t allowed_ = 0;
  int64_t retired_ = 0;  // transitions of sessions that are gone
  int64_t turn_ = 0;     // distributions so far
  TimePoint distributed_{};
};

}  // namespace cairn::learner
