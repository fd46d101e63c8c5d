#pragma once

#include "common/world/world.h"

namespace cairn {

/// A world as different eyes see it: closed doors and unseen obstacles make them differ.
struct WorldVariants {
  World known;       ///< what the planner is told
  World training;    ///< what training episodes meet
  World evaluation;  ///< what evaluation episodes meet
  bool same = true;  ///< all three are equal: nothing is closed and nothing was added
};

/// The variants of a config's world: closed doors (world.blocked_doors, random_blocked_doors, blocked_known,
/// blocked_when) and obstacles that nobody was told of (world.unseen_obstacles). `radius` [m], the robot's planning
/// radius, decides what is a passage: unseen obstacles leave one everywhere, closed doors leave the goal to at least
/// half of where it could be reached from. Depends on world.seed alone. Throws UsageError naming the field when a
/// number is no door's or when a thousand draws find no place.
WorldVariants MakeWorldVariants(const WorldConfig& config, double radius);

/// Those of an experiment. Throws UsageError besides for a vehicle that drives in a world in space or flies in a plane
/// one.
WorldVariants MakeWorldVariants(const Experiment& experiment);

}  // namespace cairn
