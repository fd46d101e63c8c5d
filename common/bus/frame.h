#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/bus/codec.h"
#include "common/bus/key_file.h"
#include "common/bus/lru_map.h"
#include "common/bus/plane.h"

namespace cairn {

/// Who sent a frame and as which one of its session's.
struct FrameInfo {
  int64_t session = 0;
  uint64_t counter = 0;
};

/// Why a datagram was refused; counted, never an error of the process.
enum class FrameFault {
  kTooShort,
  kMagic,
  kNoKey,  ///< not keyed, and this process has a key
  kKeyed,  ///< keyed, and this process has no key
  kProtocol,
  kRun,
  kChecksum,
  kTag,
  kReplay,      ///< sound, but seen before or too old to tell
  kUndecodable  ///< a sound frame around something that is not the channel's message
};
constexpr int kNumFrameFaults = 10;
const char* FrameFaultName(FrameFault fault);

/// Most bytes that a frame adds to a message: {magic u32, protocol u32, run id i64, session i64, counter u64, check},
/// big-endian, behind the standard LCM encoding, so that lcm-spy and lcm-logplayer decode frames as they are. The check
/// is a CRC32C (4 bytes) or, with a key, a GCM tag (16 bytes), and the magic says which.
constexpr size_t kTrailerBytes = 4 + 4 + 8 + 8 + 8 + 16;

/// The message inside a frame, or what is wrong with it.
struct OpenedFrame {
  std::optional<FrameFault> fault;
  FrameInfo info;
  ByteSpan message;
};

/// What AES-256-GCM needs of a session's key, made ready.
struct alignas(16) SessionContext {
  std::array<uint8_t, 512> bytes;
};

/// The contexts of sessions whose frames were sound, so that nobody without the key gets one in.
class PeerContexts : public LruMap<int64_t, SessionContext> {
 public:
  PeerContexts() : LruMap(1024) {}  // 0.6 MB
};

/// Seals and opens the frames of one run, with its key or without: a process with a key takes keyed frames only, one
/// without a key the others only. Constant after construction, so any thread may use it.
///
/// Keyed, a frame is what AES-256-GCM authenticates as additional data of an empty message; nothing is secret. Each
/// session has a key of its own, derived from the run's key, its id and the session: a frame of another run is always
/// wrong. The nonce is counter and plane, so a frame holds on its own plane only, and a session must never use a
/// counter twice.
class FrameSeal {
 public:
  /// `session` is the one that frames are sealed for.
  explicit FrameSeal(int64_t run_id, const std::optional<RunKey>& key = std::nullopt, int64_t session = 0);

  /// Appends the trailer to an encoded message. Another session than the own is slower and for tests.
  void Seal(Plane plane, const FrameInfo& info, Bytes* message) const;

  /// Checks size, magic, protocol, run and check, in this order. Replays are not seen here. `peers`, which one thread
  /// may use, keeps the contexts of senders for the next time.
  OpenedFrame Open(Plane plane, ByteSpan frame, PeerContexts* peers = nullptr) const;

  bool keyed() const { return key_.has_value(); }
  size_t trailer_bytes() const;

 private:
  SessionContext Derive(int64_t session) const;
  bool CheckHolds(Plane plane, const FrameInfo& info, ByteSpan checked, ByteSpan check, PeerContexts* peers) const;

  int64_t run_id_;
  std::optional<RunKey> key_;
  int64_t session_;
  SessionContext own_{};  // when keyed
};

/// The run that a frame says it is of, unchecked; nullopt when it does not end like a frame.
std::optional<int64_t> FrameRunId(ByteSpan frame);

}  // namespace cairn
