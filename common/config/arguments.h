#pragma once

#include "common/config/draft.h"
#include "common/config/load.h"

namespace cairn::config {

/// Applies --map, --goal and --start (not --robot). Throws UsageError naming the option.
void ApplyArguments(const PlaceArguments& arguments, Draft* draft);

}  // namespace cairn::config
