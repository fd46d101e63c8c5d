#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/config/experiment.h"
#include "common/roadmap/roadmap.h"
#include "common/world/world.h"

namespace cairn::planner {

/// A roadmap as it rests on disk, with what it was built for.
struct SavedRoadmap {
  PlannerConfig::Kind kind = PlannerConfig::Kind::kRrg;
  double radius = 0;        ///< what obstacles were inflated by [m]
  uint64_t world_hash = 0;  ///< HashOf the world
  int64_t samples = 0;      ///< that the build drew
  Roadmap roadmap;
};

/// Content hash of what bounds motion: dimension, bounds, obstacles.
uint64_t HashOf(const World& world);

/// Little-endian: "CAIRNRMP", format version u32, body bytes u64, body, CRC32C u32 of all before it. The body: kind,
/// dimension, vertices, bends, taut i32, 2 E i64, radius f64, world hash u64, samples i64, then the arrays of Roadmap.
std::string EncodeRoadmap(const SavedRoadmap& saved);

/// Throws UsageError naming `file`: no roadmap file, another format version, torn, damaged, or a graph that is none.
SavedRoadmap DecodeRoadmap(std::string_view bytes, const std::string& file);

}  // namespace cairn::planner
