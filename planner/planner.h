#pragma once

#include <string>
#include <vector>

#include "common/config/experiment.h"
#include "common/roadmap/roadmap.h"
#include "common/world/distance_field.h"
#include "common/world/world.h"

namespace cairn::planner {

/// What a roadmap build reports.
struct BuildInfo {
  PlannerConfig::Kind kind = PlannerConfig::Kind::kRrg;
  int vertices = 0;  ///< bends included
  int bends = 0;     ///< Roadmap::num_bends
  int edges = 0;
  int samples = 0;      ///< drawn
  double coverage = 0;  ///< share of free samples within r_ball of a vertex from which the goal is reached
  int components = 0;   ///< of the graph
  double build_s = 0;   ///< wall time [s]
};

struct BuiltRoadmap {
  Roadmap roadmap;
  BuildInfo info;
};

/// As in experiment.proto: "RRG", "PRM_STAR", …
const char* NameOf(PlannerConfig::Kind kind);

/// Whether a roadmap of this config can serve this world: throws UsageError for an eta that would read costs through
/// walls (with the largest that passes; what touching obstacles and imported maps hide shows after the build), a
/// spacing that cannot cover, an occupied or unreachable goal, a start region without a free point. Cheap beside
/// BuildRoadmap, which calls it too.
void CheckPlannable(const World& world, const DistanceField& field, const PlannerConfig& config,
                    double inscribed_radius);

/// Builds the roadmap of a world for obstacles inflated by config.radius (config.kind, see builders/builder.h; FCL
/// validity), or reads it from config.roadmap. `inscribed_radius` [m] of the robot enters the wall-reading rule
/// r_ball < thinnest wall + radius + inscribed_radius. Same config, same bytes.
/// Throws UsageError: eta too large (with the largest that passes), goal occupied or unreachable, sample cap reached,
/// cells that do not cover free space, a file that is not of this world.
BuiltRoadmap BuildRoadmap(const World& world, const DistanceField& field, const PlannerConfig& config,
                          double inscribed_radius);

/// The bytes of a file for PlannerConfig::roadmap (roadmap_file.h): built for `world` and config.radius.
std::string SaveRoadmap(const World& world, const PlannerConfig& config, const BuiltRoadmap& built);

/// Multi-source Dijkstra from all vertices in `goal` (paper, Algorithm "Dijkstra's Algorithm for Cost-to-Go
/// Computation"); on a taut roadmap the last leg of a way counts as far as the goal region's border. Throws UsageError
/// when no vertex lies in the goal region.
CostTable ComputeCostTable(const Roadmap& roadmap, const World& world, const Box& goal);

}  // namespace cairn::planner
