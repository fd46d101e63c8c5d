#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/config/experiment.h"

namespace cairn::learner {

using RunFields = std::vector<std::pair<std::string, std::string>>;

/// What two learners must agree on to share networks: algorithm and shapes.
RunFields NetworkFields(const Experiment& experiment);

/// What a resumed learner must agree on with the one that wrote the checkpoint: the above, the replay's meaning,
/// what the streams of random numbers and the vehicles' states belong to, and how many updates the env steps so far pay
/// for: with another ratio none would be made for a long time, or all of them at once. Other options may have been
/// changed.
RunFields ResumeFields(const Experiment& experiment);

/// Throws UsageError naming every field of `ours` that `theirs` has otherwise: "<where>: learner.net_arch is 64 64
/// there, 32 32 here".
void CheckFields(const RunFields& ours, const RunFields& theirs, const std::string& where);

}  // namespace cairn::learner
