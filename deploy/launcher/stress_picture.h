#pragma once

#include <string>
#include <vector>

#include "common/config/conditions.h"
#include "common/rl/summary.h"

namespace cairn::deploy {

/// What one controller did at one point of a knob.
struct StressResult {
  const Knob* knob = nullptr;
  const ConditionPoint* point = nullptr;
  std::string controller;  ///< policy or pure_pursuit
  EvaluationSummary summary;
};

/// Picture of success against each knob, one chart a knob, with Wilson intervals. Results come grouped by knob, in the
/// order of its points.
std::string DrawStress(const std::string& title, const std::string& subtitle, const std::vector<StressResult>& results);

}  // namespace cairn::deploy
