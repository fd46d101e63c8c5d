#pragma once

#include <memory>
#include <string>

#include "common/config/draft.h"
#include "common/world/import/import_map.h"

namespace cairn::config {

struct ReadMapResult {
  std::shared_ptr<const ImportedMap> map;  ///< null: the world is of another kind
  std::string file;                        ///< where it was read
};

/// Reads the map of a MAP world: relative to `directory`, or when it was typed on the command line to the working
/// directory. Fills world.map_hash, and points world.map to the copy that a run directory holds. Throws UsageError: a
/// field of maps without one, what ImportMap throws, a map that does not say what world.map_hash says.
ReadMapResult ReadMap(const std::string& directory, Draft* draft);

}  // namespace cairn::config
