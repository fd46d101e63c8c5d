#include "common/world/distance_field.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/core/check.h"
#include "common/world/cell_distance.h"
#include "common/world/signed_distance.h"

namespace cairn {
namespace {

constexpr double kMaxNodes = 268435456;  // 2^28, 1 GiB

Eigen::Vector3i CountNodes(const World& world, double resolution) {
  if (!(resolution > 0)) ThrowUsageError("world.field_resolution = {}: must be > 0", resolution);
  double total = 1;
  Vector3d nodes(1, 1, 1);
  for (int k = 0; k < world.dimension; ++k) {
    nodes[k] = std::max(2.0, std::ceil(world.bounds.size()[k] / resolution - 1e-9) + 1);
    total *= nodes[k];
  }
  if (total > kMaxNodes) {
    const double smallest = resolution * std::pow(total / kMaxNodes, 1.0 / world.dimension);
    ThrowUsageError("world.field_resolution = {} m: {:.3g} nodes are more than {:.0f}; must be at least {:.3g} m",
                    resolution, total, kMaxNodes, 1.01 * smallest);
  }
  return nodes.cast<int>();
}

}  // namespace

// Fills a block of nodes by halving it, dropping at each level the obstacles that cannot be the nearest one of any
// node in it: signed distances are 1-Lipschitz, so with half-diagonal h, d_i(centre) > min_j d_j(centre) + 2 h rules
// obstacle i out. Exact, and a node of the paper's maze ends up looking at two or three of some 100 boxes.
class DistanceField::Filler {
 public:
  Filler(const World& world, DistanceField& field) : world_(world), field_(field) {
    candidates_.resize(world.boxes.size() + world.cylinders.size());
    std::iota(candidates_.begin(), candidates_.end(), 0);
  }

  void Run() { Fill(Eigen::Vector3i::Zero(), field_.nodes_, 0); }

 private:
  static constexpr int kLeaf = 4;  // nodes a side

  double DistanceTo(int obstacle, const Vector3d& p) const {
    const int num_boxes = static_cast<int>(world_.boxes.size());
    if (obstacle < num_boxes) return SignedDistance(world_.boxes[obstacle], p, world_.dimension);
    return SignedDistance(world_.cylinders[obstacle - num_boxes], p, world_.dimension);
  }

  Vector3d NodePosition(const Eigen::Vector3i& node) const {
    return field_.origin_ + field_.resolution_ * node.cast<double>();
  }

  // Nodes low ≤ node < high; the candidates are candidates_[first …].
  void Fill(const Eigen::Vector3i& low, const Eigen::Vector3i& high, size_t first) {
    const size_t end = candidates_.size();
    Prune(low, high, first);
    int axis;
    if ((high - low).maxCoeff(&axis) <= kLeaf) {
      FillLeaf(low, high, end);
    } else {
      Eigen::Vector3i middle_low = low, middle_high = high;
      middle_low[axis] = middle_high[axis] = (low[axis] + high[axis]) / 2;
      Fill(low, middle_high, end);
      Fill(middle_low, high, end);
    }
    candidates_.resize(end);
  }

  // Appends those of candidates_[first …] that the block still needs.
  void Prune(const Eigen::Vector3i& low, const Eigen::Vector3i& high, size_t first) {
    const Vector3d a = NodePosition(low), b = NodePosition((high.array() - 1).matrix());
    const Vector3d center = 0.5 * (a + b);
    const size_t end = candidates_.size();
    double nearest = std::numeric_limits<double>::infinity();
    distances_.resize(end);
    for (size_t i = first; i < end; ++i) {
      distances_[i] = DistanceTo(candidates_[i], center);
      nearest = std::min(nearest, distances_[i]);
    }
    const double limit = nearest + (b - a).norm() * (1 + 1e-9);
    for (size_t i = first; i < end; ++i) {
      if (distances_[i] <= limit) candidates_.push_back(candidates_[i]);
    }
  }

  void FillLeaf(const Eigen::Vector3i& low, const Eigen::Vector3i& high, size_t first) {
    Eigen::Vector3i node;
    for (node.z() = low.z(); node.z() < high.z(); ++node.z()) {
      for (node.y() = low.y(); node.y() < high.y(); ++node.y()) {
        for (node.x() = low.x(); node.x() < high.x(); ++node.x()) {
          const Vector3d p = NodePosition(node);
          double distance = -SignedDistance(world_.bounds, p, world_.dimension);
          for (size_t i = first; i < candidates_.size(); ++i) {
            distance = std::min(distance, DistanceTo(candidates_[i], p));
          }
          const size_t row = static_cast<size_t>(node.z()) * field_.nodes_.y() + node.y();
          field_.values_[row * field_.nodes_.x() + node.x()] = static_cast<float>(distance);
        }
      }
    }
  }

  const World& world_;
  DistanceField& field_;
  std::vector<int> candidates_;    // a stack of lists, one per level
  std::vector<double> distances_;  // scratch, parallel to candidates_
};

DistanceField::DistanceField(const World& world, double resolution)
    : dimension_(world.dimension),
      resolution_(resolution),
      inverse_resolution_(1 / resolution),
      origin_(world.bounds.min),
      nodes_(CountNodes(world, resolution)),
      bounds_(world.bounds) {
  if (dimension_ == 2) origin_.z() = 0;
  if (world.imported) values_ = CellDistances(world, resolution, nodes_);
  if (!values_.empty()) return;
  values_.resize(static_cast<size_t>(nodes_.x()) * nodes_.y() * nodes_.z());
  Filler(world, *this).Run();
}

double DistanceField::interpolation_error() const { return 0.5 * resolution_ * std::sqrt(dimension_); }

double DistanceField::Distance(const Vector3d& p) const {
  int node[3] = {0, 0, 0};
  double t[3] = {0, 0, 0};
  for (int k = 0; k < dimension_; ++k) {
    if (!(p[k] >= bounds_.min[k] && p[k] <= bounds_.max[k])) return -SignedDistance(bounds_, p, dimension_);
    const double u = (p[k] - origin_[k]) * inverse_resolution_;
    node[k] = std::min(static_cast<int>(u), nodes_[k] - 2);
    t[k] = u - node[k];
  }
  const size_t stride_y = static_cast<size_t>(nodes_.x()), stride_z = stride_y * nodes_.y();
  const float* base = values_.data() + node[2] * stride_z + node[1] * stride_y + node[0];
  const auto plane = [&](const float* v) {
    const double low = v[0] + t[0] * (double{v[1]} - v[0]);
    const double high = v[stride_y] + t[0] * (double{v[stride_y + 1]} - v[stride_y]);
    return low + t[1] * (high - low);
  };
  const double lower = plane(base);
  return dimension_ == 2 ? lower : lower + t[2] * (plane(base + stride_z) - lower);
}

bool DistanceField::SegmentClear(const Vector3d& a, const Vector3d& b, double clearance) const {
  const Vector3d ab = b - a;
  const double length = dimension_ == 2 ? ab.head<2>().norm() : ab.norm();
  for (double s = 0; s < length;) {
    const double spare = Distance(a + ab * (s / length)) - clearance;
    if (!(spare >= 0)) return false;
    s += std::max(spare, smallest_step());
  }
  return Distance(b) >= clearance;
}

}  // namespace cairn
