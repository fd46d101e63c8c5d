#pragma once

#include <cstdint>
#include <optional>

#include "common/bus/codec.h"

namespace cairn {

/// Who sent a frame and as which one of its session's.
struct FrameInfo {
  int64_t session = 0;
  uint64_t counter = 0;
};

/// Why a datagram was refused; counted, never an error of the process.
enum class FrameFault { kTooShort, kMagic, kProtocol, kRun, kChecksum };
const char* FrameFaultName(FrameFault fault);

/// Bytes that a frame adds to a message: {magic u32, protocol u32, run id i64, session i64, counter u64, CRC32C u32},
/// big-endian, behind the standard LCM encoding, so that lcm-spy and lcm-logplayer decode frames as they are.
constexpr size_t kTrailerBytes = 4 + 4 + 8 + 8 + 8 + 4;

/// Appends the trailer to an encoded message.
void SealFrame(int64_t run_id, const FrameInfo& info, Bytes* message);

/// The message inside a frame, or what is wrong with it.
struct OpenedFrame {
  std::optional<FrameFault> fault;
  FrameInfo info;
  ByteSpan message;
};
OpenedFrame OpenFrame(ByteSpan frame, int64_t run_id);

}  // namespace cairn
