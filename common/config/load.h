#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/config/experiment.h"

namespace cairn {

/// Where a run directory keeps its copy of the map (CopyMap of common/world/import/import_map.h).
constexpr const char* kMapFolder = "map";

/// Where a run directory keeps its copy of planner.roadmap.
constexpr const char* kRoadmapFolder = "roadmap";

/// An experiment as read, overridden and resolved.
struct LoadedExperiment {
  Experiment experiment;
  /// Canonical protobuf text with every derived value filled in; loading it again gives the same experiment. A map is
  /// expected in the folder kMapFolder beside it, a roadmap in kRoadmapFolder.
  std::string resolved_text;
  /// Content hash of what all processes of a run must agree on: `resolved_text` without `name`, `transport` and where
  /// map and roadmap are, but with the hashes of what they say.
  uint64_t hash = 0;
};

/// What has an option of its own on the command line; empty: as in the file.
struct PlaceArguments {
  std::string map;    ///< --map: a MAP world of this file
  std::string robot;  ///< --robot: file with the text of a Vehicle, in the place of `vehicle`
  std::string goal;   ///< --goal: X,Y or X,Y,Z [m], in the place of world.goal
  std::string start;  ///< --start: likewise
};

/// Reads `path`, applies `arguments`, then `overrides` ("learner.batch_size=512", in order), reads the map if there is
/// one, derives what was left out, checks every range. Throws UsageError with file (or what was typed), line, field,
/// value, rule and the nearest known name.
LoadedExperiment LoadExperiment(const std::string& path, const std::vector<std::string>& overrides = {},
                                const PlaceArguments& arguments = {});

/// The same from text; `source` names it in errors, and a map is looked up from its folder.
LoadedExperiment ParseExperiment(const std::string& text, const std::string& source,
                                 const std::vector<std::string>& overrides = {}, const PlaceArguments& arguments = {});

}  // namespace cairn
