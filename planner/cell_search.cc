#include "planner/cell_search.h"

#include <algorithm>
#include <cmath>

#include "planner/builders/lattice.h"

namespace cairn::planner {

CellSearch::CellSearch(const CellGrid& grid, int neighbors)
    : grid_(grid),
      steps_(StepsTo(neighbors)),
      diagonal_(neighbors == 8 || neighbors == 26),
      cost_(grid.cells.size()),
      search_(grid.cells.size(), 0) {}

// The standard heap's top is its largest. Of equal estimates the one nearer to its end.
bool CellSearch::Later(const Item& a, const Item& b) {
  return a.estimate != b.estimate ? a.estimate > b.estimate : a.cost < b.cost;
}

// Length of the shortest way without obstacles: consistent, so that a cell is final when it is taken.
double CellSearch::Estimate(const Eigen::Vector3i& from, const Eigen::Vector3i& to) const {
  Eigen::Vector3i d = (to - from).cwiseAbs();
  if (!diagonal_) return d.sum();
  std::sort(d.data(), d.data() + 3);
  return d[0] * std::sqrt(3.0) + (d[1] - d[0]) * std::sqrt(2.0) + (d[2] - d[1]);
}

void CellSearch::Offer(const Eigen::Vector3i& cell, double cost, const Eigen::Vector3i& to) {
  const size_t index = grid_.Index(cell.x(), cell.y(), cell.z());
  if (search_[index] == number_ && cost_[index] <= cost) return;
  search_[index] = number_;
  cost_[index] = cost;
  heap_.push_back({cost + Estimate(cell, to), cost, cell});
  std::push_heap(heap_.begin(), heap_.end(), Later);
}

std::optional<double> CellSearch::Length(const Eigen::Vector3i& from, const Eigen::Vector3i& to) {
  if (!Free(from) || !Free(to)) return std::nullopt;
  ++number_;
  heap_.clear();
  Offer(from, 0, to);
  while (!heap_.empty()) {
    std::pop_heap(heap_.begin(), heap_.end(), Later);
    const Item item = heap_.back();
    heap_.pop_back();
    if (item.cell == to) return item.cost;
    if (item.cost > cost_[grid_.Index(item.cell.x(), item.cell.y(), item.cell.z())]) continue;
    for (int step = 0; step < kNumSteps; ++step) {
      if (!(steps_ >> step & 1)) continue;
      if (!StepFree(step, [&](const Eigen::Vector3i& offset) { return Free(item.cell + offset); })) continue;
      Offer(item.cell + StepOffset(step), item.cost + StepLength(step), to);
    }
  }
  return std::nullopt;
}

}  // namespace cairn::planner
