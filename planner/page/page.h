#pragma once

#include <string>
#include <vector>

#include "planner/picture.h"

namespace cairn::planner {

struct PageOptions {
  std::string title;          ///< heading
  std::string subtitle;       ///< small, below the heading
  double vehicle_radius = 0;  ///< of the spheres that drive the trajectories [m]
  double step = 0.1;          ///< time between two points of a trajectory [s]
  double longest_edge = 0;    ///< > 0: longer edges of the roadmap are left out [m]
  bool regions = true;        ///< draws start and goal
  bool optimal_path = true;   ///< draws OptimalPath when there is a roadmap with a table
  bool door_numbers = false;  ///< writes each door's number into it, as world.blocked_doors counts them
};

/// One HTML page that shows a world from all sides, without network: translucent walls, start and goal, the roadmap
/// (without its bends) coloured by cost-to-go, the optimal path, trajectories coloured by outcome that can be played.
/// Plane worlds get walls of a small height. `roadmap` and `table` may be null; the table is used only with its
/// roadmap. Points of trajectories that are not finite are left out. Same input, same bytes. Throws Error for a table
/// of another roadmap.
///
/// When its first frame is drawn the page says what is in it: the root element's `data-drawn` (JSON), or `data-error`.
std::string MakePage(const World& world, const Roadmap* roadmap, const CostTable* table,
                     const std::vector<Trajectory>& trajectories, const PageOptions& options);

}  // namespace cairn::planner
