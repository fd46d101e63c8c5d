#include "common/bus/frame.h"

#include "common/core/hash.h"

namespace cairn {
namespace {

constexpr uint32_t kMagic = 0x43414952;  // "CAIR"

template <typename T>
void Append(T value, Bytes* bytes) {
  for (int shift = static_cast<int>(sizeof(T)) * 8 - 8; shift >= 0; shift -= 8) {
    bytes->push_back(static_cast<uint8_t>(static_cast<uint64_t>(value) >> shift));
  }
}

template <typename T>
T Read(ByteSpan bytes, size_t* at) {
  uint64_t value = 0;
  for (size_t i = 0; i < sizeof(T); ++i) value = (value << 8) | bytes[(*at)++];
  return static_cast<T>(value);
}

}  // namespace

const char* FrameFaultName(FrameFault fault) {
  switch (fault) {
    case FrameFault::kTooShort:
      return "too short";
    case FrameFault::kMagic:
      return "not a Cairn frame";
    case FrameFault::kProtocol:
      return "another protocol version";
    case FrameFault::kRun:
      return "another run";
    case FrameFault::kChecksum:
      return "checksum";
  }
  return "unknown";
}

void SealFrame(int64_t run_id, const FrameInfo& info, Bytes* message) {
  message->reserve(message->size() + kTrailerBytes);
  Append<uint32_t>(kMagic, message);
  Append<uint32_t>(kProtocolVersion, message);
  Append<int64_t>(run_id, message);
  Append<int64_t>(info.session, message);
  Append<uint64_t>(info.counter, message);
  Append<uint32_t>(Crc32c(message->data(), message->size()), message);
}

OpenedFrame OpenFrame(ByteSpan frame, int64_t run_id) {
  OpenedFrame opened;
  if (frame.size() < kTrailerBytes) {
    opened.fault = FrameFault::kTooShort;
    return opened;
  }
  const size_t message_bytes = frame.size() - kTrailerBytes;
  size_t at = message_bytes;
  const auto magic = Read<uint32_t>(frame, &at);
  const auto protocol = Read<uint32_t>(frame, &at);
  const auto run = Read<int64_t>(frame, &at);
  opened.info.session = Read<int64_t>(frame, &at);
  opened.info.counter = Read<uint64_t>(frame, &at);
  const size_t checked = at;
  const auto crc = Read<uint32_t>(frame, &at);
  opened.message = frame.first(message_bytes);
  if (magic != kMagic) {
    opened.fault = FrameFault::kMagic;
  } else if (crc != Crc32c(frame.data(), checked)) {
    opened.fault = FrameFault::kChecksum;
  } else if (protocol != static_cast<uint32_t>(kProtocolVersion)) {
    opened.fault = FrameFault::kProtocol;
  } else if (run != run_id) {
    opened.fault = FrameFault::kRun;
  }
  return opened;
}

}  // namespace cairn
