#pragma once

#include <cstdint>
#include <vector>

#include "common/world/world.h"

namespace cairn::planner {

/// Ways of a disc or sphere among a world's obstacles. Shares nothing with the planner: every obstacle is looked at.
class StraightWays {
 public:
  StraightWays(const World& world, double radius) : world_(world), radius_(radius) {}

  /// True when the robot keeps its radius to all obstacles and bounds.
  bool Free(const Vector3d& p) const;
  /// The same all along the straight way from a to b: the distance to a convex obstacle is convex along it, so the
  /// smallest is found by golden section, to a millionth of a metre.
  bool Clear(const Vector3d& a, const Vector3d& b) const;
  /// Length of the straight way from p to the nearest point of the goal region; infinite when it is not clear.
  double ToGoal(const Vector3d& p) const;

  const World& world() const { return world_; }
  double radius() const { return radius_; }

 private:
  World world_;
  double radius_;
};

/// Length [m] of shortest ways in the plane, whatever their direction: the visibility graph over the obstacles'
/// corners, rounded by the disc. A quarter turn is made of eight straight legs around the arc: at most 0.33 % too long.
class PlaneTruth {
 public:
  PlaneTruth(const World& world, double radius);
  /// From p to the goal region; infinite when there is no way.
  double Length(const Vector3d& p) const;

 private:
  void AddArc(const Vector3d& center, double radius, double from, double to);

  StraightWays ways_;
  std::vector<Vector3d> bends_;
  std::vector<double> cost_;  // per bend [m]
};

/// Length [m] of short ways in space: Theta* (Nash et al. 2007) from the goal over a grid, every leg checked exactly;
/// then the bends of a way are moved about as long as that shortens it. Never shorter than the truth; how far it is off
/// shows when the grid is made finer.
class SpaceTruth {
 public:
  SpaceTruth(const World& world, double radius, double resolution);
  /// From p to the goal region; infinite when the grid shows no way.
  double Length(const Vector3d& p) const;

 private:
  static constexpr int32_t kNone = -2, kGoal = -1;

  size_t Index(const Eigen::Vector3i& node) const;
  Vector3d Position(int32_t node) const;
  template <typename Visit>
  void ForEachNear(const Eigen::Vector3i& node, int reach, const Visit& visit) const;
  void Search();
  void Tighten(std::vector<Vector3d>* way) const;
  double Measure(const std::vector<Vector3d>& way) const;

  StraightWays ways_;
  double resolution_;
  Eigen::Vector3i nodes_;
  std::vector<char> free_;       // per node
  std::vector<double> cost_;     // per node [m]
  std::vector<int32_t> parent_;  // per node: a node in straight reach, kGoal, kNone
};

}  // namespace cairn::planner
