#pragma once

#include "common/config/draft.h"

namespace cairn::config {

/// Fills every option that was left out: first those with a default, then the derived ones (experiment.proto says from
/// what). environment.max_episode_steps stays out: it needs the roadmap. Boxes of the world are never invented.
void Resolve(Draft* draft);

}  // namespace cairn::config
