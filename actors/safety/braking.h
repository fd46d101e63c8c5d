#pragma once

#include <vector>

#include "common/config/experiment.h"

namespace cairn::actors {

/// How fast a vehicle may approach something so that it can still stop before it: its way to a stop from a range of
/// speeds, measured on the simulated vehicle once (a few milliseconds to 0.2 s), or scaled to the declared
/// safety.stopping_distance.
class BrakingTable {
 public:
  explicit BrakingTable(const Experiment& experiment);

  /// Way [m] from the command to stand still until it stands, from `speed` [m/s] ≥ 0; convex between measured speeds.
  double StoppingDistance(double speed) const;

  /// Largest speed of approach [m/s] that leaves room to stop within `gap` [m] of free way when the next command comes
  /// after safety.period; infinite when every speed does. A gap below 0 asks for backing off: minus the speed that
  /// makes up for it within kRecovery.
  double AllowedSpeed(double gap) const;

  /// Gap from which on every speed is allowed [m].
  double reach() const { return reach_.back(); }

 private:
  double step_;                // between two measured speeds [m/s]
  std::vector<double> ways_;   // from 0, step, 2 step … [m]
  std::vector<double> reach_;  // the same with caution, and the way until the next command [m]
};

}  // namespace cairn::actors
