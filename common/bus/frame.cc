#include "common/bus/frame.h"

#include <sodium.h>

#include "common/core/check.h"
#include "common/core/hash.h"

namespace cairn {
namespace {

constexpr uint32_t kMagic = 0x43414952;       // "CAIR"
constexpr uint32_t kKeyedMagic = 0x4341494B;  // "CAIK"

constexpr size_t kFieldBytes = 4 + 4 + 8 + 8 + 8;
constexpr size_t kCrcBytes = 4;
constexpr size_t kTagBytes = crypto_aead_aes256gcm_ABYTES;
static_assert(kFieldBytes + kTagBytes == kTrailerBytes);
static_assert(sizeof(RunKey) == crypto_generichash_KEYBYTES);
using State = crypto_aead_aes256gcm_state;
static_assert(sizeof(SessionContext) == sizeof(State) && alignof(SessionContext) >= alignof(State));

// Where the library wants an encrypted message of no bytes.
unsigned char nothing = 0;

template <typename T>
void Write(T value, uint8_t** at) {
  for (int shift = static_cast<int>(sizeof(T)) * 8 - 8; shift >= 0; shift -= 8) {
    *(*at)++ = static_cast<uint8_t>(static_cast<uint64_t>(value) >> shift);
  }
}

template <typename T>
T Read(ByteSpan bytes, size_t* at) {
  uint64_t value = 0;
  for (size_t i = 0; i < sizeof(T); ++i) value = (value << 8) | bytes[(*at)++];
  return static_cast<T>(value);
}

using Nonce = std::array<uint8_t, crypto_aead_aes256gcm_NPUBBYTES>;

Nonce MakeNonce(Plane plane, const FrameInfo& info) {
  Nonce nonce{};
  uint8_t* at = nonce.data();
  Write(info.counter, &at);
  Write(static_cast<uint32_t>(plane), &at);
  return nonce;
}

void WriteTag(const SessionContext& context, const Nonce& nonce, ByteSpan covered, uint8_t* tag) {
  crypto_aead_aes256gcm_encrypt_detached_afternm(&nothing, tag, nullptr, nullptr, 0, covered.data(), covered.size(),
                                                 nullptr, nonce.data(),
                                                 reinterpret_cast<const State*>(context.bytes.data()));
}

bool TagHolds(const SessionContext& context, const Nonce& nonce, ByteSpan checked, ByteSpan tag) {
  // Compares in constant time.
  return crypto_aead_aes256gcm_decrypt_detached_afternm(nullptr, nullptr, &nothing, 0, tag.data(), checked.data(),
                                                        checked.size(), nonce.data(),
                                                        reinterpret_cast<const State*>(context.bytes.data())) == 0;
}

// Whether a frame is one of the other kind, so that a forgotten key is called that.
bool HasMagic(ByteSpan frame, size_t trailer_bytes, uint32_t magic) {
  if (frame.size() < trailer_bytes) return false;
  size_t at = frame.size() - trailer_bytes;
  return Read<uint32_t>(frame, &at) == magic;
}

}  // namespace

const char* FrameFaultName(FrameFault fault) {
  switch (fault) {
    case FrameFault::kTooShort:
      return "too short";
    case FrameFault::kMagic:
      return "not a Cairn frame";
    case FrameFault::kNoKey:
      return "sent without a key";
    case FrameFault::kKeyed:
      return "sent with a key, and this process has none";
    case FrameFault::kProtocol:
      return "another protocol version";
    case FrameFault::kRun:
      return "another run";
    case FrameFault::kChecksum:
      return "checksum";
    case FrameFault::kTag:
      return "forged, torn or sealed with another key";
    case FrameFault::kReplay:
      return "seen before";
    case FrameFault::kUndecodable:
      return "not the channel's message";
  }
  return "unknown";
}

FrameSeal::FrameSeal(int64_t run_id, const std::optional<RunKey>& key, int64_t session)
    : run_id_(run_id), key_(key), session_(session) {
  if (!keyed()) return;
  RequireKeyedFrames();
  own_ = Derive(session);
}

// A key of the session's own leaves the whole nonce to the counter, and keeps runs with the same key apart.
SessionContext FrameSeal::Derive(int64_t session) const {
  std::array<uint8_t, 30> input{'c', 'a', 'i', 'r', 'n', ' ', 's', 'e', 's', 's', 'i', 'o', 'n', ' '};
  uint8_t* at = input.data() + 14;
  Write(run_id_, &at);
  Write(session, &at);
  std::array<uint8_t, crypto_aead_aes256gcm_KEYBYTES> key;
  crypto_generichash(key.data(), key.size(), input.data(), input.size(), key_->data(), key_->size());
  SessionContext context;
  crypto_aead_aes256gcm_beforenm(reinterpret_cast<State*>(context.bytes.data()), key.data());
  return context;
}

size_t FrameSeal::trailer_bytes() const { return kFieldBytes + (keyed() ? kTagBytes : kCrcBytes); }

void FrameSeal::Seal(Plane plane, const FrameInfo& info, Bytes* message) const {
  const size_t message_bytes = message->size();
  message->resize(message_bytes + trailer_bytes());
  uint8_t* at = message->data() + message_bytes;
  Write(keyed() ? kKeyedMagic : kMagic, &at);
  Write(static_cast<uint32_t>(kProtocolVersion), &at);
  Write(run_id_, &at);
  Write(info.session, &at);
  Write(info.counter, &at);
  const size_t checked = message_bytes + kFieldBytes;
  if (!keyed()) return Write(Crc32c(message->data(), checked), &at);
  const Nonce nonce = MakeNonce(plane, info);
  const ByteSpan covered(message->data(), checked);
  info.session == session_ ? WriteTag(own_, nonce, covered, at) : WriteTag(Derive(info.session), nonce, covered, at);
}

OpenedFrame FrameSeal::Open(Plane plane, ByteSpan frame, PeerContexts* peers) const {
  OpenedFrame opened;
  const auto refuse = [&opened](FrameFault fault) {
    opened.fault = fault;
    return opened;
  };
  if (frame.size() < trailer_bytes()) return refuse(FrameFault::kTooShort);
  const size_t message_bytes = frame.size() - trailer_bytes();
  size_t at = message_bytes;
  const auto magic = Read<uint32_t>(frame, &at);
  const auto protocol = Read<uint32_t>(frame, &at);
  const auto run_id = Read<int64_t>(frame, &at);
  opened.info.session = Read<int64_t>(frame, &at);
  opened.info.counter = Read<uint64_t>(frame, &at);
  if (magic != (keyed() ? kKeyedMagic : kMagic)) {
    if (keyed() && HasMagic(frame, kFieldBytes + kCrcBytes, kMagic)) return refuse(FrameFault::kNoKey);
    if (!keyed() && HasMagic(frame, kFieldBytes + kTagBytes, kKeyedMagic)) return refuse(FrameFault::kKeyed);
    return refuse(FrameFault::kMagic);
  }
  if (protocol != static_cast<uint32_t>(kProtocolVersion)) return refuse(FrameFault::kProtocol);
  if (run_id != run_id_) return refuse(FrameFault::kRun);
  if (!CheckHolds(plane, opened.info, frame.first(at), frame.subspan(at), peers)) {
    return refuse(keyed() ? FrameFault::kTag : FrameFault::kChecksum);
  }
  opened.message = frame.first(message_bytes);
  return opened;
}

std::optional<int64_t> FrameRunId(ByteSpan frame) {
  for (const auto& [check_bytes, magic] : {std::pair(kTagBytes, kKeyedMagic), std::pair(kCrcBytes, kMagic)}) {
    if (!HasMagic(frame, kFieldBytes + check_bytes, magic)) continue;
    size_t at = frame.size() - kFieldBytes - check_bytes + 8;
    return Read<int64_t>(frame, &at);
  }
  return std::nullopt;
}

bool FrameSeal::CheckHolds(Plane plane, const FrameInfo& info, ByteSpan checked, ByteSpan check,
                           PeerContexts* peers) const {
  if (!keyed()) {
    size_t at = 0;
    return Read<uint32_t>(check, &at) == Crc32c(checked.data(), checked.size());
  }
  const Nonce nonce = MakeNonce(plane, info);
  if (info.session == session_) return TagHolds(own_, nonce, checked, check);
  const SessionContext* known = peers == nullptr ? nullptr : peers->Find(info.session);
  if (known != nullptr) return TagHolds(*known, nonce, checked, check);
  const SessionContext derived = Derive(info.session);
  if (!TagHolds(derived, nonce, checked, check)) return false;
  if (peers != nullptr) peers->Insert(info.session, derived);
  return true;
}

}  // namespace cairn
