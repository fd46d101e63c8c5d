#pragma once

#include <memory>

#include "common/roadmap/roadmap_lookup.h"
#include "common/world/distance_field.h"
#include "common/world/world.h"

namespace cairn::testing {

/// Lattice of free points (field ≥ radius), `spacing` [m] apart, joined to their 8 (in space 26) neighbours where the
/// straight line keeps `radius` [m]: a roadmap for tests that need no planner.
Roadmap MakeGridRoadmap(const World& world, const DistanceField& field, double spacing, double radius);

/// Cost-to-go from all vertices in `goal`, by a plain Dijkstra of its own.
CostTable MakeCostTable(const Roadmap& roadmap, const World& world, const Box& goal);

/// Both in one, for the world's own goal.
std::shared_ptr<const RoadmapLookup> MakeGridLookup(const World& world, const DistanceField& field, double spacing,
                                                    double radius, double r_ball);

}  // namespace cairn::testing
