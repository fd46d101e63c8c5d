#pragma once

#include <cstdint>
#include <vector>

#include "common/config/experiment.h"
#include "common/roadmap/roadmap.h"
#include "planner/collision/free_space.h"

namespace cairn::planner {

/// What a builder starts from; borrows all but the point.
struct BuildTask {
  const FreeSpace& space;
  const DistanceField& field;  ///< of the space's world
  const PlannerConfig& config;
  Vector3d goal_point;  ///< free point of the goal region with the most room
};

/// What a builder made.
struct Grown {
  Roadmap roadmap;      ///< neighbours ascending; at least one vertex in the goal region
  int64_t samples = 0;  ///< drawn, or cells looked at
  double coverage = 0;  ///< share of free samples within r_ball of a vertex from which the goal is reached
  PlannerConfig::Kind kind = PlannerConfig::Kind::kRrg;  ///< filled in by Grow
};

/// Whether a kind gives one path, not costs from everywhere.
inline bool IsPath(PlannerConfig::Kind kind) {
  return kind == PlannerConfig::Kind::kRrt || kind == PlannerConfig::Kind::kRrtStar;
}

/// Free samples on which coverage is measured.
constexpr int kCoverageSamples = 20000;

/// Reads config.roadmap or builds what config.kind names, the same bytes for the same task. Throws UsageError: the
/// sample cap is reached, nothing of the goal region is free by exact test, the file is not for this task.
Grown Grow(const BuildTask& task);

// A builder for each kind, see Grow.

/// The roadmap in the file config.roadmap, of whatever kind that is, for the same world and radius.
Grown GrowFromFile(const BuildTask& task);
/// Ends on coverage and connects what coverage is too coarse to notice.
Grown GrowRrg(const BuildTask& task);
/// OMPL's PRM*, ends on coverage by the milestones that are joined to the goal; only they are kept.
Grown GrowPrmStar(const BuildTask& task);
/// RRT and RRT_STAR, OMPL's: one path from the free point of the start region nearest to its centre to the goal region,
/// its vertices in order and no farther apart than config.min_spacing (0: r_ball).
Grown GrowPath(const BuildTask& task);
/// The cells of a lattice that are joined to one in the goal region, their centres as vertices in [z][y][x] order. A
/// step is an edge when the robot fits at all cells that it touches (no corner is cut) and on all its way. Its lengths
/// are whole multiples of 1, √2 and √3 cells.
Grown GrowGrid(const BuildTask& task);

/// First vertices of a roadmap: the goal region's roomiest point and what fits beside it at the spacing, so that a goal
/// region of several parts is entered everywhere. Throws UsageError when none is free by exact test.
std::vector<Vector3d> ChooseRoots(const BuildTask& task);

/// Throws UsageError naming planner.max_samples and the coverage reached.
[[noreturn]] void ThrowSampleCap(const PlannerConfig& config, double coverage);

}  // namespace cairn::planner
