#pragma once

#include <cstdint>
#include <vector>

#include "common/config/experiment.h"
#include "common/roadmap/roadmap.h"
#include "planner/collision/free_space.h"

namespace cairn::planner {

/// What a builder starts from; borrows the space and the config.
struct BuildTask {
  const FreeSpace& space;
  const PlannerConfig& config;
  Vector3d goal_point;  ///< free point of the goal region with the most room
};

/// What a builder made.
struct Grown {
  Roadmap roadmap;      ///< neighbours ascending; at least one vertex in the goal region
  int64_t samples = 0;  ///< drawn, or cells looked at
  double coverage = 0;  ///< share of free samples within r_ball of a vertex from which the goal is reached
};

/// Free samples on which coverage is measured.
constexpr int kCoverageSamples = 20000;

/// Builds what config.kind names, the same bytes for the same task. Throws UsageError: the sample cap is reached,
/// nothing of the goal region is free by exact test.
Grown Grow(const BuildTask& task);

/// A builder for each kind, see Grow. The RRG ends on coverage and connects what coverage is too coarse to notice.
Grown GrowRrg(const BuildTask& task);

/// First vertices of a roadmap: the goal region's roomiest point and what fits beside it at the spacing, so that a goal
/// region of several parts is entered everywhere. Throws UsageError when none is free by exact test.
std::vector<Vector3d> ChooseRoots(const BuildTask& task);

/// Throws UsageError naming planner.max_samples and the coverage reached.
[[noreturn]] void ThrowSampleCap(const PlannerConfig& config, double coverage);

}  // namespace cairn::planner
