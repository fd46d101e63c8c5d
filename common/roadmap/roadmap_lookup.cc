#include "common/roadmap/roadmap_lookup.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/core/check.h"

namespace cairn {
namespace {

constexpr double kMaxCells = 4194304;

}  // namespace

// Cells of side 2 r_ball: a ball touches at most four (eight in space), and since each cell lists its vertices cheapest
// first, D(s) leaves a cell at the first vertex inside the ball or no cheaper than the best so far.
RoadmapLookup::RoadmapLookup(int dimension, std::vector<float> positions, CostTable table, double r_ball, int num_bends)
    : dimension_(dimension),
      positions_(std::move(positions)),
      table_(std::move(table)),
      table_hash_(table_.Hash()),
      r_ball_(r_ball),
      num_places_(num_vertices() - num_bends) {
  Check();
  Vector3d low = Vector3d::Zero(), high = Vector3d::Zero();
  for (int v = 0; v < num_vertices(); ++v) {
    low = v == 0 ? position(v) : low.cwiseMin(position(v));
    high = v == 0 ? position(v) : high.cwiseMax(position(v));
  }
  origin_ = low;
  double cell = 2 * r_ball;
  const auto count = [&] { return ((high - low) / cell).array().floor() + 1; };
  while (count().prod() > kMaxCells) cell *= 2;
  inverse_cell_ = 1 / cell;
  cells_ = count().cast<int>();

  std::vector<std::vector<Entry>> lists(static_cast<size_t>(cells_.prod()));
  for (int v = 0; v < num_vertices(); ++v) {
    if (!std::isfinite(table_.cost[v])) continue;
    const Vector3d p = position(v);
    const int index = (CellIndex(2, p.z()) * cells_.y() + CellIndex(1, p.y())) * cells_.x() + CellIndex(0, p.x());
    lists[index].push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()),
                            table_.cost[v], static_cast<int32_t>(v)});
  }
  offsets_.push_back(0);
  for (auto& list : lists) {
    std::stable_sort(list.begin(), list.end(), [](const Entry& a, const Entry& b) { return a.cost < b.cost; });
    entries_.insert(entries_.end(), list.begin(), list.end());
    offsets_.push_back(static_cast<int32_t>(entries_.size()));
  }
}

void RoadmapLookup::Check() const {
  const size_t vertices = table_.cost.size();
  if (dimension_ != 2 && dimension_ != 3) ThrowError("roadmap lookup: dimension {} is neither 2 nor 3", dimension_);
  if (positions_.size() != vertices * static_cast<size_t>(dimension_) || table_.next_vertex.size() != vertices) {
    ThrowError("roadmap lookup: {} coordinates, {} costs and {} next vertices do not fit dimension {}",
               positions_.size(), vertices, table_.next_vertex.size(), dimension_);
  }
  if (num_places_ < 0 || num_places_ > num_vertices()) {
    ThrowError("roadmap lookup: {} vertices without the bends, {} with them", num_places_, num_vertices());
  }
  if (!(r_ball_ > 0 && std::isfinite(r_ball_))) ThrowError("roadmap lookup: r_ball = {} m must be > 0", r_ball_);
  for (const float coordinate : positions_) {
    if (!std::isfinite(coordinate)) ThrowError("roadmap lookup: vertex coordinate {} is not finite", coordinate);
  }
  for (const int32_t next : table_.next_vertex) {
    if (next < -1 || next >= static_cast<int64_t>(vertices)) {
      ThrowError("roadmap lookup: next vertex {} is none of the {} vertices", next, vertices);
    }
  }
}

size_t RoadmapLookup::num_bytes() const {
  return sizeof(*this) + sizeof(float) * (positions_.size() + table_.cost.size() + table_.marks.size()) +
         sizeof(int32_t) * (table_.next_vertex.size() + offsets_.size()) + sizeof(Entry) * entries_.size();
}

Vector3d RoadmapLookup::position(int vertex) const {
  const float* p = positions_.data() + static_cast<size_t>(vertex) * dimension_;
  return Vector3d(p[0], p[1], dimension_ == 3 ? p[2] : 0.0f);
}

int RoadmapLookup::CellIndex(int axis, double coordinate) const {
  const double cell = std::floor((coordinate - origin_[axis]) * inverse_cell_);
  return static_cast<int>(std::clamp(cell, 0.0, static_cast<double>(cells_[axis] - 1)));
}

double RoadmapLookup::SquaredDistance(const Entry& entry, const Vector3d& p) const {
  const double x = entry.x - p.x(), y = entry.y - p.y(), z = dimension_ == 3 ? entry.z - p.z() : 0;
  return x * x + y * y + z * z;
}

// A way out of a mark's reach is open, one that leads nearer to it is not.
bool RoadmapLookup::Cut(const Vector3d& p, const Entry& entry) const {
  const Vector3d to(entry.x, entry.y, dimension_ == 3 ? entry.z : 0);
  Vector3d from = p;
  if (dimension_ == 2) from.z() = 0;
  const Vector3d way = to - from;
  const double squared_length = way.squaredNorm();
  for (size_t m = 0; m < table_.marks.size(); m += 3) {
    const Vector3d mark(table_.marks[m], table_.marks[m + 1], dimension_ == 3 ? table_.marks[m + 2] : 0);
    const double at = (mark - from).dot(way);
    if (at <= 0) continue;  // nearest where it begins
    const double t = std::min(1.0, at / squared_length);
    const double nearest = (from + t * way - mark).squaredNorm();
    if (nearest < static_cast<double>(table_.mark_reach) * table_.mark_reach) return true;
  }
  return false;
}

// Calls visit(first, last) with the entries of each cell that a ball may touch.
template <typename Visit>
void RoadmapLookup::ForEachCell(const Vector3d& p, double radius, const Visit& visit) const {
  int low[3] = {0, 0, 0}, high[3] = {0, 0, 0};
  for (int k = 0; k < dimension_; ++k) {
    if (!std::isfinite(p[k])) return;
    low[k] = CellIndex(k, p[k] - radius);
    high[k] = CellIndex(k, p[k] + radius);
  }
  for (int z = low[2]; z <= high[2]; ++z) {
    for (int y = low[1]; y <= high[1]; ++y) {
      for (int x = low[0]; x <= high[0]; ++x) {
        const int cell = (z * cells_.y() + y) * cells_.x() + x;
        visit(entries_.data() + offsets_[cell], entries_.data() + offsets_[cell + 1]);
      }
    }
  }
}

float RoadmapLookup::CostToGo(const Vector3d& p) const {
  float best = kUnreachable;
  const double limit = r_ball_ * r_ball_;
  ForEachCell(p, r_ball_, [&](const Entry* entry, const Entry* last) {
    for (; entry != last && entry->cost < best; ++entry) {
      if (entry->vertex >= num_places_ || SquaredDistance(*entry, p) > limit || Cut(p, *entry)) continue;
      best = entry->cost;
    }
  });
  return best;
}

int RoadmapLookup::BestEntry(const Vector3d& p, const DistanceField& field, double clearance) const {
  int best = -1;
  double best_length = std::numeric_limits<double>::infinity();
  const double limit = 4 * r_ball_ * r_ball_;
  ForEachCell(p, 2 * r_ball_, [&](const Entry* entry, const Entry* last) {
    for (; entry != last && entry->cost < best_length; ++entry) {
      const double squared = SquaredDistance(*entry, p);
      if (squared > limit) continue;
      const double length = std::sqrt(squared) + entry->cost;
      if (length >= best_length || Cut(p, *entry) || !field.SegmentClear(p, position(entry->vertex), clearance))
        continue;
      best = entry->vertex;
      best_length = length;
    }
  });
  return best;
}

// By visiting all: only for points far from every vertex or in contact with a wall.
int RoadmapLookup::NearestVertex(const Vector3d& p) const {
  int best = -1;
  double best_squared = std::numeric_limits<double>::infinity();
  for (const Entry& entry : entries_) {
    const double squared = SquaredDistance(entry, p);
    if (squared < best_squared && !Cut(p, entry)) {
      best = entry.vertex;
      best_squared = squared;
    }
  }
  return best;
}

int RoadmapLookup::EntryVertex(const Vector3d& p, const DistanceField& field, double clearance) const {
  int vertex = BestEntry(p, field, clearance);
  if (vertex < 0 && clearance > 0) vertex = BestEntry(p, field, 0);
  return vertex >= 0 ? vertex : NearestVertex(p);
}

// The last leg leads to the middle of the goal: paths end at its edge, and a vehicle before that would have nothing
// ahead.
Vector3d RoadmapLookup::PointAlong(const Vector3d& p, int entry, double distance) const {
  CAIRN_CHECK(entry >= 0 && entry < num_vertices(), "entry vertex {} of {}", entry, num_vertices());
  Vector3d from = p, to = p;
  if (dimension_ == 2) from.z() = 0;
  const auto arrives = [&](const Vector3d& next) {
    to = next;
    const double length = (to - from).norm();
    if (distance <= length) {
      if (length > 0) to = from + (to - from) * (distance / length);
      return true;
    }
    distance -= length;
    from = to;
    return false;
  };
  int vertex = entry;
  // At most V edges, so that a table with a cycle (never ours) cannot hang the caller.
  for (int edges = 0; edges <= num_vertices(); ++edges) {
    if (arrives(position(vertex))) return to;
    if (table_.next_vertex[vertex] < 0) break;
    vertex = table_.next_vertex[vertex];
  }
  if (table_.cost[vertex] == 0) {
    Vector3d middle = table_.goal.center();
    if (dimension_ == 2) middle.z() = 0;
    arrives(middle);
  }
  return to;
}

}  // namespace cairn
