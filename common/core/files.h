#pragma once

#include <string>

namespace cairn {

/// Writes beside, fsyncs, renames: readers see the old file or the whole new one. A device or pipe is written to as it
/// is, and what a link leads to is replaced. Throws Error naming the path and the system's reason (disk full, …) and
/// leaves nothing half-written.
void WriteFileAtomically(const std::string& path, const std::string& text);

/// Syncs the directory that holds `path`: a new name is lost in a crash unless its directory is on disk. Throws Error.
void SyncDirectoryOf(const std::string& path);

/// The whole of a file. Throws Error naming the path and the system's reason.
std::string ReadFile(const std::string& path);

}  // namespace cairn
