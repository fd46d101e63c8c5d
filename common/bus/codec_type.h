#pragma once

#include <optional>
#include <utility>

#include "common/bus/codec.h"
#include "common/bus/size_walker.h"
#include "common/core/check.h"

// What the codec_*.cc files share; generated LCM types are seen by them alone.
namespace cairn::codec {

template <typename Type>
Bytes EncodeType(const Type& type) {
  Bytes bytes(static_cast<size_t>(type.getEncodedSize()));
  const int written = type.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  CAIRN_CHECK(written == static_cast<int>(bytes.size()), "encoded {} of {} bytes", written, bytes.size());
  return bytes;
}

/// The walker has already proved that the counts fit the bytes; what is left for decode to refuse is the fingerprint.
template <typename Type>
std::optional<Type> DecodeType(ByteSpan bytes, bool sizes_agree) {
  Type type{};
  if (!sizes_agree) return std::nullopt;
  if (type.decode(bytes.data(), 0, static_cast<int>(bytes.size())) != static_cast<int>(bytes.size())) {
    return std::nullopt;
  }
  return type;
}

inline int64_t Signed(uint64_t hash) { return static_cast<int64_t>(hash); }
inline uint64_t Unsigned(int64_t hash) { return static_cast<uint64_t>(hash); }

inline bool ValidSet(int8_t set) { return set >= 0 && set <= static_cast<int8_t>(StartSet::kTest); }

}  // namespace cairn::codec
