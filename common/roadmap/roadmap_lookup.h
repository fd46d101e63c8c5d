#pragma once

#include <vector>

#include "common/roadmap/roadmap.h"
#include "common/world/distance_field.h"

namespace cairn {

/// D(s) of the paper and look-ahead points, over a CSR bucket grid of the vertices. Immutable; any thread.
class RoadmapLookup {
 public:
  /// `positions` is [V × dimension], the last `num_bends` of them bends (Roadmap::num_bends). Throws Error when its
  /// size disagrees with the table's, a next_vertex is no vertex, a position is not finite, or r_ball ≤ 0.
  RoadmapLookup(int dimension, std::vector<float> positions, CostTable table, double r_ball, int num_bends = 0);

  /// D(s): the smallest cost-to-go [m] over vertices but the bends within r_ball of p, kUnreachable when there is none.
  /// Here and below a vertex counts for nothing where the straight line to it nears a mark of the table to less than
  /// its reach, unless it leads away from it.
  float CostToGo(const Vector3d& p) const;

  /// Vertex v within 2 r_ball of p that minimises |p − v| + cost(v) among those whose straight line from p keeps
  /// `clearance` [m] in `field`; falls back to clearance 0, then to the nearest vertex with finite cost; −1 when there
  /// is none.
  int EntryVertex(const Vector3d& p, const DistanceField& field, double clearance) const;

  /// Point at arc length `distance` [m] from p along p → entry vertex → next_vertex … → middle of the goal,
  /// interpolated on edges; its end when the path is shorter. `entry` ≥ 0.
  Vector3d PointAlong(const Vector3d& p, int entry, double distance) const;

  const CostTable& table() const { return table_; }
  /// Content hash of the table.
  uint64_t table_hash() const { return table_hash_; }
  /// Memory that it holds [bytes], about.
  size_t num_bytes() const;
  Vector3d position(int vertex) const;
  int num_vertices() const { return static_cast<int>(table_.cost.size()); }
  /// Vertices before the bends.
  int num_places() const { return num_places_; }
  double r_ball() const { return r_ball_; }
  int dimension() const { return dimension_; }

 private:
  // A vertex with finite cost, packed for the scan.
  struct Entry {
    float x, y, z, cost;
    int32_t vertex;
  };

  void Check() const;
  bool Cut(const Vector3d& p, const Entry& entry) const;
  int CellIndex(int axis, double coordinate) const;
  double SquaredDistance(const Entry& entry, const Vector3d& p) const;
  template <typename Visit>
  void ForEachCell(const Vector3d& p, double radius, const Visit& visit) const;
  int BestEntry(const Vector3d& p, const DistanceField& field, double clearance) const;
  int NearestVertex(const Vector3d& p) const;

  int dimension_;
  std::vector<float> positions_;
  CostTable table_;
  uint64_t table_hash_;
  double r_ball_;
  int num_places_;       // vertices before the bends
  double inverse_cell_;  // 1 / side of a cell [1/m]
  Vector3d origin_;
  Eigen::Vector3i cells_;
  std::vector<int32_t> offsets_;  // per cell
  std::vector<Entry> entries_;    // by cell, cheapest first
};

}  // namespace cairn
