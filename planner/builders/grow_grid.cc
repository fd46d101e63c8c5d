#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "common/core/check.h"
#include "planner/builders/builder.h"
#include "planner/builders/coverage.h"
#include "planner/builders/lattice.h"

namespace cairn::planner {
namespace {

// What room the robot has at a cell's centre: none, some, or enough for each step from there.
enum class Room : uint8_t { kNone, kSome, kAllSteps };

// Sized for maps of 16 million cells: 9 bytes a cell, besides the roadmap.
class Grid {
 public:
  explicit Grid(const BuildTask& task)
      : task_(task),
        world_(task.space.world()),
        lattice_(world_.bounds, world_.dimension, task.config.grid_cell),
        steps_(StepsTo(task.config.grid_neighbors)) {}

  Grown Build() {
    FindRoom();
    FindOpenSteps();
    room_ = {};
    NumberVertices();
    CheckCoverage();
    return {MakeRoadmap(), lattice_.num_cells(), coverage_};
  }

 private:
  template <typename Visit>
  void ForEachCell(const Visit& visit) const {
    lattice_.Any(std::nullopt, [&](const Eigen::Vector3i& cell, int64_t index) {
      visit(cell, static_cast<size_t>(index));
      return false;
    });
  }

  // A step is at most one diagonal long and takes no more than its length off the room: where there is that much to
  // spare, which in the open is everywhere, nothing else has to be tested.
  void FindRoom() {
    const double roomy =
        task_.config.radius + lattice_.cell() * std::sqrt(world_.dimension) + task_.field.interpolation_error();
    room_.resize(static_cast<size_t>(lattice_.num_cells()), Room::kNone);
    ForEachCell([&](const Eigen::Vector3i& cell, size_t index) {
      const Vector3d p = lattice_.Center(cell);
      if (task_.field.Distance(p) >= roomy) {
        room_[index] = Room::kAllSteps;
      } else if (task_.space.checker().Free(p)) {
        room_[index] = Room::kSome;
      }
    });
  }

  // Each step is tested once, from the lower of its cells.
  void FindOpenSteps() {
    open_.resize(room_.size(), 0);
    ForEachCell([&](const Eigen::Vector3i& cell, size_t index) {
      if (room_[index] == Room::kNone) return;
      for (int step = kNoStep + 1; step < kNumSteps; ++step) {
        if (!(steps_ >> step & 1) || !IsOpen(cell, step)) continue;
        open_[index] |= 1u << step;
        open_[Moved(index, step)] |= 1u << Opposite(step);
      }
    });
  }

  bool IsOpen(const Eigen::Vector3i& cell, int step) const {
    const auto room = [&](const Eigen::Vector3i& at) {
      return lattice_.Contains(at) ? room_[static_cast<size_t>(lattice_.Index(at))] : Room::kNone;
    };
    if (!StepFree(step, [&](const Eigen::Vector3i& offset) { return room(cell + offset) != Room::kNone; }))
      return false;
    const Eigen::Vector3i to = cell + StepOffset(step);
    if (room(cell) == Room::kAllSteps || room(to) == Room::kAllSteps) return true;
    return task_.space.checker().MotionFree(lattice_.Center(cell), lattice_.Center(to));
  }

  size_t Moved(size_t index, int step) const {
    return static_cast<size_t>(static_cast<int64_t>(index) + lattice_.Stride(step));
  }

  // Vertices are the cells that are joined to one whose centre lies in the goal region, in ascending order.
  void NumberVertices() {
    vertex_.assign(open_.size(), -1);
    std::vector<int32_t> front, next;
    const auto visit = [&](size_t index, std::vector<int32_t>* to) {
      if (std::exchange(vertex_[index], 0) == 0) return;
      to->push_back(static_cast<int32_t>(index));
    };
    lattice_.Any(world_.goal, [&](const Eigen::Vector3i& cell, int64_t index) {
      const Vector3d p = lattice_.Center(cell);
      if (world_.Contains(world_.goal, p) && task_.space.Contains(p)) visit(static_cast<size_t>(index), &front);
      return false;
    });
    if (front.empty()) {
      ThrowUsageError("planner.grid_cell = {} m: no cell's centre in world.goal is free for planner.radius = {} m",
                      lattice_.cell(), task_.config.radius);
    }
    for (; !front.empty(); front.swap(next), next.clear()) {
      for (const int32_t from : front) {
        for (uint32_t steps = open_[static_cast<size_t>(from)]; steps != 0; steps &= steps - 1) {
          visit(Moved(static_cast<size_t>(from), std::countr_zero(steps)), &next);
        }
      }
    }
    for (int32_t& vertex : vertex_) {
      if (vertex == 0) vertex = num_vertices_++;
    }
  }

  void CheckCoverage() {
    const PlannerConfig& config = task_.config;
    Coverage coverage(task_.space, config.r_ball(), kCoverageSamples, config.seed);
    coverage_ = coverage.ShareOf([&](const Vector3d& p) {
      const Vector3d r = Vector3d::Constant(config.r_ball());
      return lattice_.Any(Box{p - r, p + r}, [&](const Eigen::Vector3i& cell, int64_t index) {
        return vertex_[static_cast<size_t>(index)] >= 0 && (lattice_.Center(cell) - p).norm() <= config.r_ball();
      });
    });
    if (coverage_ >= config.coverage) return;
    const double smaller = 0.5 * std::min(lattice_.cell(), config.eta / std::sqrt(world_.dimension));
    ThrowUsageError(
        "planner.grid_cell = {} m: cells cover {:.5f} of free space within r_ball = eta / 2, below planner.coverage = "
        "{}; a smaller cell covers more: try {:.4g} m",
        lattice_.cell(), coverage_, config.coverage, smaller);
  }

  Roadmap MakeRoadmap() const {
    Roadmap roadmap;
    roadmap.dimension = world_.dimension;
    size_t num_steps = 0;
    for (size_t i = 0; i < vertex_.size(); ++i) num_steps += vertex_[i] < 0 ? 0 : std::popcount(open_[i]);
    roadmap.positions.reserve(static_cast<size_t>(num_vertices_) * world_.dimension);
    roadmap.offsets.reserve(static_cast<size_t>(num_vertices_) + 1);
    roadmap.neighbors.reserve(num_steps);
    roadmap.lengths.reserve(num_steps);
    roadmap.offsets.push_back(0);
    ForEachCell([&](const Eigen::Vector3i& cell, size_t index) {
      if (vertex_[index] < 0) return;
      const Vector3d p = lattice_.Center(cell);
      for (int k = 0; k < world_.dimension; ++k) roadmap.positions.push_back(static_cast<float>(p[k]));
      for (uint32_t steps = open_[index]; steps != 0; steps &= steps - 1) {
        const int step = std::countr_zero(steps);
        roadmap.neighbors.push_back(vertex_[Moved(index, step)]);
        roadmap.lengths.push_back(static_cast<float>(lattice_.cell() * StepLength(step)));
      }
      roadmap.offsets.push_back(static_cast<int32_t>(roadmap.neighbors.size()));
    });
    return roadmap;
  }

  const BuildTask& task_;
  const World& world_;
  Lattice lattice_;
  uint32_t steps_;
  std::vector<Room> room_;       // per cell
  std::vector<uint32_t> open_;   // per cell: set of steps
  std::vector<int32_t> vertex_;  // per cell; −1: none
  int32_t num_vertices_ = 0;
  double coverage_ = 0;
};

}  // namespace

Grown GrowGrid(const BuildTask& task) { return Grid(task).Build(); }

}  // namespace cairn::planner
