#pragma once

#include <string>

#include "common/config/draft.h"

namespace cairn::config {

/// Applies one `key=value`, as typed after --set; a list is written `learner.net_arch=[64,64]` and replaces the
/// whole list, a text needs no quotes. Throws UsageError naming the override.
void ApplyOverride(const std::string& assignment, Draft* draft);

}  // namespace cairn::config
