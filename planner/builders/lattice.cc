#include "planner/builders/lattice.h"

#include "common/core/check.h"
#include "planner/collision/free_space.h"

namespace cairn::planner {
namespace {

constexpr double kMaxCells = 134217728;  // 2^27, as of maps

}  // namespace

uint32_t StepsTo(int neighbors) {
  const bool space = neighbors == 6 || neighbors == 26, diagonal = neighbors == 8 || neighbors == 26;
  uint32_t steps = 0;
  for (int step = 0; step < kNumSteps; ++step) {
    const Eigen::Vector3i offset = StepOffset(step);
    if (step == kNoStep || (!space && offset.z() != 0) || (!diagonal && offset.squaredNorm() > 1)) continue;
    steps |= 1u << step;
  }
  return steps;
}

Lattice::Lattice(const Box& bounds, int dimension, double cell)
    : dimension_(dimension), cell_(cell), origin_(bounds.min), size_(1, 1, 1) {
  Vector3d counts(1, 1, 1);
  for (int k = 0; k < dimension; ++k) {
    counts[k] = std::max(1.0, std::floor(bounds.size()[k] / cell + 1e-6));
    origin_[k] += 0.5 * (bounds.size()[k] - counts[k] * cell);
  }
  if (counts.prod() > kMaxCells) {
    ThrowUsageError("planner.grid_cell = {} m: {:.3g} cells are more than {:.0f}; must be at least {:.3g} m", cell,
                    counts.prod(), kMaxCells, 1.01 * cell * std::pow(counts.prod() / kMaxCells, 1.0 / dimension));
  }
  size_ = counts.cast<int>();
}

Vector3d Lattice::Center(const Eigen::Vector3i& cell) const {
  return RoundToFloat(origin_ + cell_ * (cell.cast<double>().array() + 0.5).matrix(), dimension_);
}

Eigen::Vector3i Lattice::CellAt(const Vector3d& p) const {
  Eigen::Vector3i cell(0, 0, 0);
  for (int k = 0; k < dimension_; ++k) {
    cell[k] = static_cast<int>(std::clamp(std::floor((p[k] - origin_[k]) / cell_), 0.0, size_[k] - 1.0));
  }
  return cell;
}

}  // namespace cairn::planner
