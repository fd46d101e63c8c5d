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
  /// messages and many frames, which all of them hear.
  CreditLedger(int64_t total, int64_t enough) : total_(total), enough_(enough) {}

  /// Transitions that may be made so far, capped at the total; never lower than before.
  void Allow(int64_t allowed);

  /// A session is gone after this many accepted transitions: what it had not used is free again.
  void Retire(int64_t accepted) { retired_ += accepted; }

  /// Hands out what is free, to those first that have least left of what they were given, so that one that hangs does
  /// not gather it all. Waits until `share` (0 … 1) of `enough` is free or 50 ms have passed. True when anybody got
  /// any.
  bool Distribute(Fleet* fleet, double share, TimePoint now);

 private:
  static constexpr auto kPatience = std::chrono::milliseconds(50);

  int64_t total_;
  int64_t enough_;
  int64_t allowed_ = 0;
  int64_t retired_ = 0;  // transitions of sessions that are gone
  TimePoint distributed_{};
};

}  // namespace cairn::learner
