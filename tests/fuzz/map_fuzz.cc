// A map file's bytes, CAIRN_FUZZ_READER's format; what is read goes on to become obstacles. A map may be refused with a
// line that says why, and nothing else may happen.
#include <cstdint>
#include <string>

#include "common/core/check.h"
#include "common/world/import/gazebo_world.h"
#include "common/world/import/moving_ai.h"
#include "common/world/import/moving_ai_scenario.h"
#include "common/world/import/octomap.h"
#include "common/world/import/ros_map.h"

namespace cairn {
namespace {

constexpr int64_t kMaxCells = 1 << 16;
const std::string kFile = "fuzz";

void Use(const CellGrid& grid) {
  for (const Box& box : MergeBoxes(CropToFree(grid, std::nullopt, 1, kFile))) {
    CAIRN_CHECK((box.size().array() >= 0).all() && box.max.allFinite() && box.min.allFinite());
  }
}

RosMapInfo Info() {
  RosMapInfo info;
  info.resolution = 0.05;
  info.origin = {1, 2, 0.3};
  info.occupied_thresh = 0.65;
  info.free_thresh = 0.196;
  return info;
}

[[maybe_unused]] void ReadPgmBytes(const std::string& bytes) { Use(ReadRosMap(Info(), bytes, "fuzz.pgm", kMaxCells)); }

// A chunk's checksum, so that the fuzzer gets past it.
uint32_t Crc32(const char* data, size_t size) {
  uint32_t crc = ~0u;
  for (size_t i = 0; i < size; ++i) {
    crc ^= static_cast<uint8_t>(data[i]);
    for (int k = 0; k < 8; ++k) crc = (crc & 1) != 0 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
  }
  return ~crc;
}

std::string WithSoundChecksums(std::string png) {
  for (size_t at = 8; at + 12 <= png.size();) {
    uint32_t length = 0;
    for (size_t k = 0; k < 4; ++k) length = length << 8 | static_cast<uint8_t>(png[at + k]);
    if (length > png.size() - at - 12) break;
    const uint32_t crc = Crc32(png.data() + at + 4, length + 4);
    for (size_t k = 0; k < 4; ++k) png[at + 8 + length + k] = static_cast<char>(crc >> (24 - 8 * k));
    at += 12 + length;
  }
  return png;
}

[[maybe_unused]] void ReadPngBytes(const std::string& bytes) {
  RosMapInfo info = Info();
  info.mode = RosMapInfo::Mode::kScale;
  Use(ReadRosMap(info, WithSoundChecksums(bytes), "fuzz.png", kMaxCells));
}

[[maybe_unused]] void ReadRosYamlBytes(const std::string& bytes) {
  const RosMapInfo info = ParseRosMapInfo(bytes, kFile);
  const RosMapInfo again = ParseRosMapInfo(PrintRosMapInfo(info, "image.pgm"), kFile);
  CAIRN_CHECK(again.image == "image.pgm" && again.origin == info.origin && again.free_thresh == info.free_thresh);
  Use(ReadRosMap(info, "P2 3 2 255 255 0 255 205 255 255", "fuzz.pgm", kMaxCells));
}

[[maybe_unused]] void ReadMovingAiBytes(const std::string& bytes) { Use(ReadMovingAi(bytes, kFile, 0.5, kMaxCells)); }

[[maybe_unused]] void ReadScenarioBytes(const std::string& bytes) {
  const Scenario scenario = ReadScenario(bytes, kFile);
  for (const ScenarioPath& path : scenario.paths) {
    CAIRN_CHECK(path.start[0] >= 0 && path.start[0] < scenario.width && path.goal[1] >= 0 &&
                path.goal[1] < scenario.height && path.length >= 0);
  }
}

[[maybe_unused]] void ReadOctomapBytes(const std::string& bytes) {
  try {
    Use(ReadOctomap(bytes, kFile, std::nullopt, kMaxCells));
  } catch (const Error&) {
    // too large in space, perhaps not in a slice
  }
  Use(ReadOctomap(bytes, kFile, Slice{-1638.4, 1}, kMaxCells));
}

[[maybe_unused]] void ReadGazeboBytes(const std::string& bytes) {
  for (const Cylinder& c : ReadGazeboWorld(bytes, kFile, std::nullopt).cylinders) {
    CAIRN_CHECK(c.radius > 0 && c.base.allFinite());
  }
}

#define CAIRN_JOIN3(a, b, c) a##b##c
#define CAIRN_READ(reader) CAIRN_JOIN3(Read, reader, Bytes)

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    cairn::CAIRN_READ(CAIRN_FUZZ_READER)(std::string(reinterpret_cast<const char*>(data), size));
  } catch (const cairn::UsageError&) {
    // refused by name
  }
  return 0;
}
