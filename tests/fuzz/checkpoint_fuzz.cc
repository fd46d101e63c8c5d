// A checkpoint file's bytes. Half of the inputs become the body of a frame that is sound, so that the fuzzer gets past
// it.
#include <cstdint>
#include <cstring>
#include <string>

#include "common/core/check.h"
#include "common/core/hash.h"
#include "learner/checkpoint/checkpoint_file.h"

namespace {

void Decode(const std::string& bytes) {
  try {
    cairn::learner::DecodeCheckpoint(bytes, "fuzz");
  } catch (const cairn::Error&) {
    // refused by name
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string body(reinterpret_cast<const char*>(data), size);
  Decode(body);
  static const std::string kEmpty = cairn::learner::EncodeCheckpoint({});
  std::string framed = kEmpty.substr(0, 12);  // magic and format version
  const auto length = static_cast<uint64_t>(size);
  framed.append(reinterpret_cast<const char*>(&length), sizeof(length));
  framed += body;
  const uint32_t crc = cairn::Crc32c(framed.data(), framed.size());
  framed.append(reinterpret_cast<const char*>(&crc), sizeof(crc));
  Decode(framed);
  return 0;
}
