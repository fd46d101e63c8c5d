#pragma once

#include "common/roadmap/roadmap.h"
#include "planner/collision/free_space.h"

namespace cairn::planner {

/// Brings the costs along a roadmap near those of free directions, whatever built it: adds bends
/// (Roadmap::num_bends, see FindBends) and free edges of up to 2 eta [m], but none that two edges replace by a way 2 %
/// longer at most. Vertices and edges that there are stay; neighbours become ascending.
///
/// Measured in the car maze at spacing eta / 2, against exact shortest ways: costs are 9 to 15 % long on edges of up to
/// eta, 6 to 10 % with longer edges alone, under 1 % with both.
void AddTautWays(const FreeSpace& space, double eta, Roadmap* roadmap);

}  // namespace cairn::planner
