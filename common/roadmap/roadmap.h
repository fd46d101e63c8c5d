#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "common/world/world.h"

namespace cairn {

/// Undirected graph of collision-free straight edges, G = (V, E) of the paper. Edges as CSR, each stored both ways.
struct Roadmap {
  int dimension = 2;
  /// The last so many vertices stand where ways bend around obstacles. They make costs shorter, and ways lead over
  /// them; D(s) does not see them, so that they add no drops of D_min to be rewarded.
  int num_bends = 0;
  /// Edges are straight ways, not steps of a lattice: what they cost ends where they enter a goal region.
  bool taut = false;
  std::vector<float> positions;    ///< [V × dimension], W frame [m]
  std::vector<int32_t> offsets;    ///< [V + 1]
  std::vector<int32_t> neighbors;  ///< [2 E]
  std::vector<float> lengths;      ///< [2 E], Euclidean [m]

  int num_vertices() const { return static_cast<int>(positions.size()) / dimension; }
  /// Vertices that D(s) sees: those before the bends.
  int num_places() const { return num_vertices() - num_bends; }
  int num_edges() const { return static_cast<int>(neighbors.size()) / 2; }
  Vector3d position(int vertex) const;
  /// Content hash of PackPositions: what actors receive; never 0.
  uint64_t Hash() const;
};

constexpr float kUnreachable = std::numeric_limits<float>::infinity();

/// Cost-to-go of every vertex for one goal region (paper: Cost; Algorithm "Dijkstra's Algorithm for Cost-to-Go").
struct CostTable {
  uint64_t roadmap_hash = 0;
  Box goal;
  std::vector<float> cost;           ///< [V], path length to the goal region [m], kUnreachable if there is none
  std::vector<int32_t> next_vertex;  ///< [V], next on the shortest path; −1 at goal vertices and unreachable ones
  /// Marked obstacles that the roadmap's own checks did not know: [3 × marks], centres in W [m]. A straight line is cut
  /// where it nears one to less than `mark_reach` [m].
  std::vector<float> marks{};
  float mark_reach = 0;

  /// Longest finite cost [m]; 0 for an empty table.
  float max_cost() const;
  /// Content hash of PackTable; never 0.
  uint64_t Hash() const;
};

}  // namespace cairn
