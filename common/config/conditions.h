#pragma once

#include <string>
#include <vector>

namespace cairn {

/// One value of a knob and the overrides of the experiment that make it.
struct ConditionPoint {
  double value = 0;
  std::vector<std::string> overrides;  ///< "environment.slip=0.1"
};

/// A quantity that is varied while everything else stays.
struct Knob {
  std::string name;
  std::string unit;  ///< of the values; may be empty
  std::vector<ConditionPoint> points;
};

/// A stress page: what common/config/conditions.proto describes.
struct Conditions {
  int trials = 1000;                   ///< at each point
  std::vector<std::string> overrides;  ///< at every point
  std::vector<Knob> knobs;
};

/// Reads a file of conditions for a vehicle with this circumscribed radius [m], the unit of lengths that end in R.
/// Throws UsageError with file, line and rule.
Conditions LoadConditions(const std::string& path, double radius);

}  // namespace cairn
