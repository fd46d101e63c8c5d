#pragma once

#include <string>

namespace cairn::config {

/// Path of the field in which the character at (line, column), both from 0, of a protobuf text stands: "learner" or
/// "learner.batch_size". Works on broken text up to that place. Protobuf's own parse errors do not say it.
std::string FieldPathAt(const std::string& text, int line, int column);

}  // namespace cairn::config
