#pragma once

namespace cairn {

/// Git revision this binary was built from, twelve digits, with "-dirty" when the tree was modified; "unknown" outside
/// a git checkout. Processes of one run must agree on it.
const char* GitRevision();

/// Version of the project, "0.1.0".
const char* ProjectVersion();

}  // namespace cairn
