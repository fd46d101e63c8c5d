#pragma once

#include <string>

namespace cairn {

/// Writes beside, fsyncs, renames: readers see the old file or the whole new one. Throws Error naming the path and the
/// system's reason (disk full, …) and leaves nothing half-written.
void WriteFileAtomically(const std::string& path, const std::string& text);

/// The whole of a file. Throws Error naming the path and the system's reason.
std::string ReadFile(const std::string& path);

}  // namespace cairn
