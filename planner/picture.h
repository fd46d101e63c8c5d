#pragma once

#include <string>
#include <vector>

#include "common/rl/episode.h"
#include "common/roadmap/roadmap.h"
#include "common/world/world.h"
#include "planner/value_map.h"

namespace cairn::planner {

/// A driven path and how it ended, for pictures.
struct Trajectory {
  std::vector<Vector3d> points;  ///< W [m]
  Outcome outcome = Outcome::kRunning;
};

struct PictureOptions {
  std::string title;                 ///< bold, above the map
  std::string subtitle;              ///< small, below the title
  double width = 760;                ///< of the map without margins [px]
  double r_ball = 0;                 ///< > 0: tints free space by D(s) with this radius [m]
  double longest_edge = 0;           ///< > 0: longer edges of the roadmap are left out [m]
  bool regions = true;               ///< draws start and goal
  bool optimal_path = true;          ///< draws OptimalPath when there is a roadmap with a table
  bool door_numbers = false;         ///< writes each door's number into it, as world.blocked_doors counts them
  const ValueMap* values = nullptr;  ///< coloured cells below the walls with a colour bar of their own; without a table
};

/// SVG of a plane world to metric scale: walls, start and goal, the roadmap (without its bends) coloured by cost-to-go
/// with its colour bar, the optimal path, and trajectories coloured by outcome (the roadmap then steps back). `roadmap`
/// and `table` may be null; the table is used only with its roadmap. Same input, same bytes. Throws Error for worlds in
/// space and for a table of another roadmap.
std::string DrawScene(const World& world, const Roadmap* roadmap, const CostTable* table,
                      const std::vector<Trajectory>& trajectories, const PictureOptions& options);

}  // namespace cairn::planner
