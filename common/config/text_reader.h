#pragma once

#include <string>

#include "common/config/draft.h"

namespace cairn::config {

/// Parses protobuf text. Throws UsageError "source:line: field: what; rule" at the first thing that is wrong.
Draft ReadText(const std::string& text, const std::string& source);

}  // namespace cairn::config
