#pragma once

#include "common/config/draft.h"

namespace cairn::config {

/// Checks what one field alone cannot tell, on a resolved draft. Throws UsageError naming both fields, their values,
/// where they were typed, and the rule.
void CheckRules(const Draft& draft);

}  // namespace cairn::config
