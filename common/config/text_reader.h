#pragma once

#include <string>

#include "common/config/draft.h"

namespace cairn::config {

/// Parses protobuf text. Throws UsageError "source:line: field: what; rule" at the first thing that is wrong.
Draft ReadText(const std::string& text, const std::string& source);

/// Parses the protobuf text of a Vehicle and puts it in the place of the draft's; errors as above, fields as
/// "vehicle.…".
void ReadVehicle(const std::string& text, const std::string& source, Draft* draft);

}  // namespace cairn::config
