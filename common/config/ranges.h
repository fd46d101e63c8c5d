#pragma once

#include <string>

#include "common/config/draft.h"

namespace cairn::config {

/// What a field accepts, in words: "it must be a whole number in [1, 1048576] transitions".
std::string Rule(const google::protobuf::FieldDescriptor& field);

/// Checks every value in the draft against the annotations of experiment.proto; NaN and infinities never pass.
/// Throws UsageError with origin, field, value and rule.
void CheckRanges(const Draft& draft);

}  // namespace cairn::config
