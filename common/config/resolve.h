#pragma once

#include "common/config/draft.h"
#include "common/world/import/import_map.h"

namespace cairn::config {

/// Fills every option that was left out: first those with a default, then the derived ones (experiment.proto says from
/// what). environment.max_episode_steps stays out: it needs the roadmap. Boxes and points of the world are never
/// invented. `map` is the map of a MAP world, else null.
void Resolve(Draft* draft, const ImportedMap* map);

}  // namespace cairn::config
