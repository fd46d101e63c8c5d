#pragma once

#include <ompl/base/Goal.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>

#include <vector>

#include "common/world/world.h"
#include "planner/collision/free_space.h"

namespace cairn::planner {

/// OMPL's view of a free space: R² or R³ within the world's bounds; states are valid when the robot's sphere is free,
/// motions when it is free all the way (FCL, exact); valid-state samplers draw from `FreeSpace` with a RandomStream of
/// (seed, kPlanner), never from OMPL's global generator. Interpolated states are rounded to float as a
/// roadmap stores them. `space` must outlive it. The first sampler allocated draws
/// the same states each time.
ompl::base::SpaceInformationPtr MakeSpaceInformation(const FreeSpace& space, uint64_t seed);

/// State of R² or R³ ↔ position in W [m].
Vector3d ToPosition(const ompl::base::State* state, int dimension);
void ToState(const Vector3d& p, int dimension, ompl::base::State* state);

/// A goal for OMPL: a box of the world.
ompl::base::GoalPtr MakeRegionGoal(const ompl::base::SpaceInformationPtr& information, const World& world,
                                   const Box& region);

/// From each of `starts` to `goal`.
ompl::base::ProblemDefinitionPtr MakeProblem(const ompl::base::SpaceInformationPtr& information,
                                             const std::vector<Vector3d>& starts, const ompl::base::GoalPtr& goal);

}  // namespace cairn::planner
