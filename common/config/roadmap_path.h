#pragma once

#include <string>

#include "common/config/draft.h"

namespace cairn::config {

/// Finds the file of planner.roadmap, if any: relative to `directory`, or when it was typed on the command line to the
/// working directory. Fills planner.roadmap_hash, and points planner.roadmap to the copy that a run directory holds.
/// Returns where the file was found, empty without one. Throws UsageError: no such file, a hash without a roadmap, a
/// file that is not the one of planner.roadmap_hash.
std::string FindRoadmap(const std::string& directory, Draft* draft);

}  // namespace cairn::config
