#pragma once

#include <cstddef>
#include <string>

#include "learner/checkpoint/run_state.h"

namespace cairn::learner {

/// Bytes of a checkpoint file: {magic, format version, size, body, CRC32C of all before}. The body is
/// checkpoint.proto's Checkpoint, whose sections have a CRC32C each. Throws Error when that is larger than
/// CheckCheckpointSize allows.
std::string EncodeCheckpoint(const RunState& state);

/// Throws Error when a body of `bytes` cannot be written: 2 GiB or more.
void CheckCheckpointSize(size_t bytes);

/// Reads what EncodeCheckpoint made; the replay's rows stay in their files. Throws Error naming `path` and what is
/// wrong: cut off or damaged (and which section); UsageError when it is whole and of another format version.
RunState DecodeCheckpoint(const std::string& bytes, const std::string& path);

}  // namespace cairn::learner
