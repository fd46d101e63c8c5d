// A roadmap file's bytes. Half of the inputs become the body of a frame that is sound, so that the fuzzer gets past it.
#include <cstdint>
#include <cstring>
#include <string>

#include "common/core/check.h"
#include "common/core/hash.h"
#include "planner/roadmap_file.h"

namespace {

constexpr size_t kHeaderBytes = 20, kVersionEnd = 12;

// What is read is a graph that writes back to the same bytes.
void Decode(const std::string& bytes) {
  try {
    const cairn::planner::SavedRoadmap saved = cairn::planner::DecodeRoadmap(bytes, "fuzz");
    CAIRN_CHECK(cairn::planner::EncodeRoadmap(saved) == bytes);
    for (const int32_t neighbor : saved.roadmap.neighbors) {
      CAIRN_CHECK(neighbor >= 0 && neighbor < saved.roadmap.num_vertices());
    }
  } catch (const cairn::UsageError&) {
    // refused by name
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string body(reinterpret_cast<const char*>(data), size);
  Decode(body);
  static const std::string kSmall = [] {
    cairn::planner::SavedRoadmap saved;
    saved.roadmap.positions = {0, 0};
    saved.roadmap.offsets = {0, 0};
    return cairn::planner::EncodeRoadmap(saved);
  }();
  std::string framed = kSmall.substr(0, kVersionEnd);
  const auto length = static_cast<uint64_t>(size);
  framed.append(reinterpret_cast<const char*>(&length), sizeof(length));
  static_assert(kVersionEnd + sizeof(length) == kHeaderBytes);
  framed += body;
  const uint32_t crc = cairn::Crc32c(framed.data(), framed.size());
  framed.append(reinterpret_cast<const char*>(&crc), sizeof(crc));
  Decode(framed);
  return 0;
}
