#pragma once

#include <vector>

#include "common/roadmap/roadmap.h"
#include "tests/planner/any_angle.h"
#include "tests/planner/cost_worlds.h"

namespace cairn::planner {

/// How much longer ways along a roadmap are than the shortest ones, over random starts.
struct CostError {
  int starts = 0;
  double mean = 0;  ///< of cost / truth − 1
  double largest = 0;
  double smallest = 0;  ///< below 0 when the truth is too long
};

/// Over `starts` points, uniform in what is free for the planner's radius, outside of the goal region. What a start
/// costs is the cheapest straight way to a vertex within eta plus that vertex's cost. The truth: PlaneTruth, or
/// SpaceTruth on a grid of `resolution` [m].
CostError MeasureCosts(const CostWorld& scene, const Roadmap& roadmap, int starts, double resolution = 0.0125);

/// Of `samples` points where the robot's inscribed sphere is free: how often the straight line to the vertex whose cost
/// is D(s) meets an obstacle. `finite` receives how many have a finite D(s).
int CountReadThroughWalls(const CostWorld& scene, const Roadmap& roadmap, int samples, int* finite);

}  // namespace cairn::planner
