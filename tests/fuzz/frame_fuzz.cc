// A datagram as it comes from the network, to a process with a key and to one without. What a sealed input becomes with
// one bit flipped must be refused.
#include <cstdint>
#include <cstdlib>

#include "common/bus/frame.h"

namespace {

void Try(const cairn::FrameSeal& seal, const uint8_t* data, size_t size) {
  const cairn::OpenedFrame opened = seal.Open(cairn::Plane::kControl, cairn::ByteSpan(data, size));
  if (!opened.fault && opened.message.size() > size) std::abort();
  cairn::Bytes sealed(data, data + size);
  seal.Seal(cairn::Plane::kControl, {1, 2}, &sealed);
  const cairn::OpenedFrame sound = seal.Open(cairn::Plane::kControl, sealed);
  if (sound.fault || sound.message.size() != size || sound.info.counter != 2) std::abort();
  if (size == 0) return;
  sealed[data[0] % sealed.size()] ^= 1;
  if (!seal.Open(cairn::Plane::kControl, sealed).fault) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const cairn::FrameSeal plain(7);
  static const cairn::FrameSeal keyed(7, cairn::RunKey{});
  Try(plain, data, size);
  Try(keyed, data, size);
  return 0;
}
