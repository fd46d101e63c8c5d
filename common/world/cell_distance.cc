#include "common/world/cell_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace cairn {
namespace {

constexpr double kFar = 1e15;     // squared, in nodes: more than any grid has
constexpr double kOnNode = 1e-6;  // of the resolution
constexpr int kBlock = 16;        // columns transformed together, so that memory is read in whole cache lines

// The lower envelope of parabolas, section 2 of the paper: d[q] = min over p of (q − p)² + f[p].
class LineTransform {
 public:
  explicit LineTransform(int size) : apexes_(size), borders_(size + 1) {}

  void Run(const double* f, double* d, int size) {
    const double infinity = std::numeric_limits<double>::infinity();
    int last = 0;
    apexes_[0] = 0;
    borders_[0] = -infinity;
    for (int q = 1; q < size; ++q) {
      double border = Crossing(f, apexes_[last], q);
      while (border <= borders_[last]) border = Crossing(f, apexes_[--last], q);
      apexes_[++last] = q;
      borders_[last] = border;
    }
    borders_[last + 1] = infinity;
    for (int q = 0, k = 0; q < size; ++q) {
      while (borders_[k + 1] < q) ++k;
      const double offset = q - apexes_[k];
      d[q] = offset * offset + f[apexes_[k]];
    }
  }

 private:
  // Where the parabola at q becomes lower than the one at p < q.
  static double Crossing(const double* f, int p, int q) {
    const double dp = p, dq = q;
    return (f[q] + dq * dq - f[p] - dp * dp) / (2 * (dq - dp));
  }

  std::vector<int> apexes_;
  std::vector<double> borders_;
};

class Transform {
 public:
  Transform(const World& world, double resolution, const Eigen::Vector3i& nodes)
      : dimension_(world.dimension), resolution_(resolution), nodes_(nodes), cells_(1, 1, 1) {
    for (int k = 0; k < dimension_; ++k) cells_[k] = nodes[k] - 1;
    occupied_.assign(static_cast<size_t>(cells_.x()) * cells_.y() * cells_.z(), 0);
  }

  // False when something does not lie on nodes.
  bool Paint(const World& world) {
    if (!world.cylinders.empty() || !PaintCells(world, world.bounds, 0)) return false;
    for (int k = 0; k < dimension_; ++k) {
      if (std::abs(world.bounds.size()[k] / resolution_ - cells_[k]) > kOnNode * cells_[k]) return false;
    }
    const auto paint = [&](const Box& box) { return PaintCells(world, box, 1); };
    return std::all_of(world.boxes.begin(), world.boxes.end(), paint);
  }

  std::vector<float> Run() {
    std::vector<float> outside = SquaredDistances([](int adjacent, int) { return adjacent > 0; });
    const std::vector<float> inside = SquaredDistances([](int adjacent, int all) { return adjacent < all; });
    for (size_t i = 0; i < outside.size(); ++i) {
      const double squared = double{outside[i]} - double{inside[i]};  // one of them is 0
      outside[i] = static_cast<float>(std::copysign(resolution_ * std::sqrt(std::abs(squared)), squared));
    }
    return outside;
  }

 private:
  size_t NodeIndex(int x, int y, int z) const {
    return (static_cast<size_t>(z) * nodes_.y() + y) * nodes_.x() + static_cast<size_t>(x);
  }

  bool PaintCells(const World& world, const Box& box, uint8_t value) {
    std::array<int, 3> low{0, 0, 0}, high{1, 1, 1};
    for (int k = 0; k < dimension_; ++k) {
      const double a = (box.min[k] - world.bounds.min[k]) / resolution_;
      const double b = (box.max[k] - world.bounds.min[k]) / resolution_;
      if (std::abs(a - std::round(a)) > kOnNode || std::abs(b - std::round(b)) > kOnNode) return false;
      low[k] = static_cast<int>(std::clamp<double>(std::round(a), 0, cells_[k]));
      high[k] = static_cast<int>(std::clamp<double>(std::round(b), 0, cells_[k]));
    }
    for (int z = low[2]; z < high[2]; ++z) {
      for (int y = low[1]; y < high[1]; ++y) {
        const size_t row = (static_cast<size_t>(z) * cells_.y() + y) * cells_.x();
        std::fill(occupied_.begin() + static_cast<std::ptrdiff_t>(row + low[0]),
                  occupied_.begin() + static_cast<std::ptrdiff_t>(row + std::max(low[0], high[0])), value);
      }
    }
    return true;
  }

  bool Occupied(int x, int y, int z) const {  // what is outside is
    if (x < 0 || y < 0 || z < 0 || x >= cells_.x() || y >= cells_.y() || z >= cells_.z()) return true;
    return occupied_[(static_cast<size_t>(z) * cells_.y() + y) * cells_.x() + x] != 0;
  }

  // Occupied ones of the 4 (8) cells that meet at a node.
  int Adjacent(int x, int y, int z) const {
    int count = 0;
    for (int dz = dimension_ == 3 ? -1 : 0; dz <= 0; ++dz) {
      count += Occupied(x - 1, y - 1, z + dz) + Occupied(x, y - 1, z + dz);
      count += Occupied(x - 1, y, z + dz) + Occupied(x, y, z + dz);
    }
    return count;
  }

  // Squared distance [nodes²] of each node to the nearest one for which is_seed(occupied cells, all cells) is true.
  template <typename IsSeed>
  std::vector<float> SquaredDistances(const IsSeed& is_seed) const {
    std::vector<float> squared(static_cast<size_t>(nodes_.x()) * nodes_.y() * nodes_.z());
    const int all = dimension_ == 3 ? 8 : 4;
    for (int z = 0; z < nodes_.z(); ++z) {
      for (int y = 0; y < nodes_.y(); ++y) {
        float* row = squared.data() + NodeIndex(0, y, z);
        for (int x = 0; x < nodes_.x(); ++x) row[x] = is_seed(Adjacent(x, y, z), all) ? 0 : static_cast<float>(kFar);
      }
    }
    const auto plane = static_cast<size_t>(nodes_.x()) * nodes_.y();
    for (int z = 0; z < nodes_.z(); ++z) {
      for (int y = 0; y < nodes_.y(); ++y) TransformLines(squared.data() + NodeIndex(0, y, z), nodes_.x(), 1, 1);
      TransformLines(squared.data() + z * plane, nodes_.y(), static_cast<size_t>(nodes_.x()), nodes_.x());
    }
    for (int y = 0; y < nodes_.y() && dimension_ == 3; ++y) {
      TransformLines(squared.data() + NodeIndex(0, y, 0), nodes_.z(), plane, nodes_.x());
    }
    return squared;
  }

  // Transforms `count` lines that begin beside each other, of `size` values `stride` apart.
  static void TransformLines(float* first, int size, size_t stride, int count) {
    LineTransform line(size);
    std::vector<double> f(static_cast<size_t>(size) * kBlock), d(static_cast<size_t>(size));
    for (int begin = 0; begin < count; begin += kBlock) {
      const int width = std::min(kBlock, count - begin);
      for (int i = 0; i < size; ++i) {
        for (int k = 0; k < width; ++k) f[static_cast<size_t>(k) * size + i] = first[i * stride + begin + k];
      }
      for (int k = 0; k < width; ++k) {
        double* column = f.data() + static_cast<size_t>(k) * size;
        line.Run(column, d.data(), size);
        std::copy(d.begin(), d.end(), column);
      }
      for (int i = 0; i < size; ++i) {
        for (int k = 0; k < width; ++k) {
          first[i * stride + begin + k] = static_cast<float>(std::min(f[static_cast<size_t>(k) * size + i], kFar));
        }
      }
    }
  }

  int dimension_;
  double resolution_;
  Eigen::Vector3i nodes_, cells_;
  std::vector<uint8_t> occupied_;  // per cell
};

}  // namespace

std::vector<float> CellDistances(const World& world, double resolution, const Eigen::Vector3i& nodes) {
  Transform transform(world, resolution, nodes);
  if (!transform.Paint(world)) return {};
  return transform.Run();
}

}  // namespace cairn
