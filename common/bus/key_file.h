#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace cairn {

/// The secret that the processes of a run share. Whoever holds it can speak as any of them.
using RunKey = std::array<uint8_t, 32>;

/// Throws UsageError when this processor lacks the instructions that keyed frames need: software AES would be slow and
/// leak the key through time.
void RequireKeyedFrames();

/// Makes a random key and writes it to a new file of mode 0600: 64 hexadecimal digits and a newline, synced to the
/// disk. Throws Error naming the file when it exists already or cannot be written; nothing half-written is left then.
RunKey CreateKeyFile(const std::string& path);

/// Reads one back. Throws UsageError naming the file, what is wrong (missing, mode, length, digit; never the digits
/// themselves) and the rule.
RunKey ReadKeyFile(const std::string& path);

}  // namespace cairn
