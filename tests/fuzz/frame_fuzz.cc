// A datagram as it comes from the network. Half of the inputs get a sound trailer, so that the fuzzer gets past it.
#include <cstdint>
#include <cstdlib>

#include "common/bus/frame.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr int64_t kRun = 7;
  const cairn::OpenedFrame opened = cairn::OpenFrame(cairn::ByteSpan(data, size), kRun);
  if (!opened.fault && opened.message.size() + cairn::kTrailerBytes != size) std::abort();
  cairn::Bytes sealed(data, data + size);
  cairn::SealFrame(kRun, {1, 2}, &sealed);
  const cairn::OpenedFrame sound = cairn::OpenFrame(sealed, kRun);
  if (sound.fault || sound.message.size() != size || sound.info.counter != 2) std::abort();
  if (size > 0) {
    sealed[data[0] % sealed.size()] ^= 1;
    if (!cairn::OpenFrame(sealed, kRun).fault) std::abort();
  }
  return 0;
}
