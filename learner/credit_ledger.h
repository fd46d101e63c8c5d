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
  /// `total`: transitions of the whole run. `enough`: transitions worth waking the actors for; small shares make small
  /// messages and many frames, which all of them hear. `burst`: transitions worth having one of them work.
  CreditLedger(int64_t total, int64_t enough, int64_t burst) : total_(total), enough_(enough), burst_(burst) {}

  /// Transitions that may be made so far, capped at the total; never lower than before.
  void Allow(int64_t allowed);

  /// A session is gone after this many accepted transitions: what it had not used is free again.
  void Retire(int64_t accepted) { retired_ += accepted; }

  /// Hands out what is free, to those first that have least left of what they were given, so that one that hangs does
  /// not gather it all; actors that are faster than credit comes get bursts in turn. Waits until `enough` is free or
  /// `patience` has passed since the last time. True when anybody got any.
  bool Distribute(Fleet* fleet, Duration patience, TimePoint now);

 private:
  int64_t total_;
  int64_t enough_;
  int64_t burst_;
  int64_t allowed_ = 0;
  int64_t retired_ = 0;  // transitions of sessions that are gone
  int64_t turn_ = 0;     // distributions so far
  TimePoint distributed_{};
};

}  // namespace cairn::learner
