#pragma once

#include <nlohmann/json.hpp>

#include "common/rl/summary.h"

namespace cairn::deploy {

/// The keys that `cairn eval --json` prints of a summary; SI units.
nlohmann::ordered_json ToJson(const EvaluationSummary& summary);

}  // namespace cairn::deploy
