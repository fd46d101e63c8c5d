#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/config/experiment.h"

namespace cairn {

using Eigen::Vector3d;

/// Axis-aligned box in W [m]. In a plane world (dimension 2) z is 0 and ignored everywhere.
struct Box {
  Vector3d min = Vector3d::Zero();
  Vector3d max = Vector3d::Zero();

  Vector3d center() const { return 0.5 * (min + max); }
  Vector3d size() const { return max - min; }
};

/// Upright cylinder in W; in a plane world a disc.
struct Cylinder {
  Vector3d base = Vector3d::Zero();  ///< centre of the lower face [m]
  double radius = 0;                 ///< [m]
  double height = 0;                 ///< [m]
};

/// What stands where: immutable once made, shared by planner, simulation and pictures.
/// Everything outside `bounds` is occupied.
struct World {
  int dimension = 2;  ///< 2: motion in the plane, 3: in space
  Box bounds;
  std::vector<Box> boxes;
  std::vector<Cylinder> cylinders;
  std::vector<Box> doors;  ///< holes that could be closed; no obstacles (mazes)
  Box start;
  Box goal;
  Box start_space;  ///< where starts are drawn from, unless environment.start says otherwise
  /// The obstacles are a map's cells merged as it came: they say nothing about how thick walls are.
  bool imported = false;
  /// Obstacles that meet overlap by a wall's thickness, as a maze's do, so that no wall is thinner than the thinnest
  /// obstacle. Where they only touch, at corners or along arcs, it is.
  bool walls_overlap = false;

  /// True when p lies in the region, edges included, over this world's dimensions.
  bool Contains(const Box& region, const Vector3d& p) const;
};

/// Builds the world the config describes. Throws UsageError naming the field when a region is missing, empty or outside
/// the bounds or the maze's squares do not fit; see also Reachability in common/world/reachability.h.
World MakeWorld(const WorldConfig& config);

/// The same of a map without a goal yet: start and goal are all of its bounds.
World MakeWorldWithoutGoal(const WorldConfig& config);

/// The region around a point: a square (cube) of half side `tolerance` [m], but no larger than what the obstacles leave
/// around the point, within the bounds. Around a point inside an obstacle it is next to nothing.
Box RegionAround(const World& world, const Vector3d& point, double tolerance);

/// The paper's Car-2D maze (Experimental Setup): `cells`² perfect maze by depth-first search, `loop_fraction` of the
/// remaining inner walls opened, walls inside start and goal squares cleared, wall runs merged into boxes.
/// Side length: cells (corridor + wall) + wall, lower left corner at the origin. Same seed, same boxes.
World MakeCarMaze(const WorldConfig& config);

}  // namespace cairn
