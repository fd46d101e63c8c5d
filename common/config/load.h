#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/config/experiment.h"

namespace cairn {

/// An experiment as read, overridden and resolved.
struct LoadedExperiment {
  Experiment experiment;
  /// Canonical protobuf text with every derived value filled in; loading it again gives the same experiment.
  std::string resolved_text;
  /// Content hash of what all processes of a run must agree on: `resolved_text` without `name` and `transport`.
  uint64_t hash = 0;
};

/// Reads `path`, applies `overrides` ("learner.batch_size=512", in order), derives what was left out, checks every
/// range. Throws UsageError with file (or the override), line, field, value, rule and the nearest known name.
LoadedExperiment LoadExperiment(const std::string& path, const std::vector<std::string>& overrides = {});

/// The same from text; `source` names it in errors.
LoadedExperiment ParseExperiment(const std::string& text, const std::string& source,
                                 const std::vector<std::string>& overrides = {});

}  // namespace cairn
