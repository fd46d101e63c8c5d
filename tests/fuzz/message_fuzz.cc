// One message type (CAIRN_FUZZ_MESSAGE): whatever the bytes, decoding neither crashes nor allocates more than the
// message is long by orders of magnitude, and what it accepts survives being encoded and decoded again.
#include <cstdint>
#include <cstdlib>

#include "common/bus/codec.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using Message = cairn::CAIRN_FUZZ_MESSAGE;
  const auto message = cairn::Decode<Message>(cairn::ByteSpan(data, size));
  if (!message) return 0;
  const cairn::Bytes again = cairn::Encode(*message);
  if (!cairn::Decode<Message>(again)) std::abort();
  return 0;
}
