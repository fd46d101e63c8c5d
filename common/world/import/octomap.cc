#include "common/world/import/octomap.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/core/check.h"

namespace cairn {
namespace {

constexpr int kDepth = 16;                  // of an OcTree: leaves of the lowest level are voxels
constexpr int kCenter = 1 << (kDepth - 1);  // key of the voxel whose lower corner is the origin of W

// A leaf: `side` voxels from `low`, in keys.
struct Leaf {
  Eigen::Vector3i low;
  int side;
  bool occupied;
};

struct Header {
  double resolution = 0;
  size_t data = 0;  // byte at which the tree begins
};

Header ParseHeader(std::string_view bytes, const std::string& file) {
  constexpr std::string_view kMagic = "# Octomap OcTree binary file";
  Header header;
  std::string id;
  for (int number = 1; header.data < bytes.size(); ++number) {
    const size_t end = bytes.find('\n', header.data);
    if (end == std::string_view::npos || end - header.data > 200) break;
    const std::string_view line = bytes.substr(header.data, end - header.data);
    header.data = end + 1;
    if (number == 1 && line.substr(0, kMagic.size()) != kMagic) break;
    if (line.substr(0, 3) == "id ") id = line.substr(3);
    if (line.substr(0, 4) == "res ") {
      const auto [at, error] = std::from_chars(line.data() + 4, line.data() + line.size(), header.resolution);
      if (error != std::errc()) ThrowUsageError("{}:{}: res is not a number", file, number);
    }
    if (line != "data") continue;
    if (id != "OcTree") ThrowUsageError("{}: id = \"{}\"; only OcTree is read", file, id.substr(0, 40));
    return header;
  }
  ThrowUsageError("{}: not an OctoMap binary tree (.bt): its header goes from \"{}\" to a line \"data\"", file, kMagic);
}

// Walks the tree: two bytes a node, two bits a child (01 free, 10 occupied, 11 has children itself), children first
// to last. Everything is bounded by the bytes there are.
template <typename Visit>
class Walker {
 public:
  Walker(std::string_view data, const std::string& file, const Visit& visit)
      : data_(data), file_(file), visit_(visit) {}

  void Run() {
    if (!data_.empty()) Walk(Eigen::Vector3i::Zero(), 1 << kDepth);
  }

 private:
  void Walk(const Eigen::Vector3i& low, int side) {
    if (data_.size() - at_ < 2) ThrowUsageError("{}: torn: the tree goes on after its last byte ({})", file_, at_);
    if (side == 1) ThrowUsageError("{}: deeper than {} levels at byte {} of the tree", file_, kDepth, at_);
    const unsigned bits = static_cast<uint8_t>(data_[at_]) | static_cast<unsigned>(static_cast<uint8_t>(data_[at_ + 1]))
                                                                 << 8;
    at_ += 2;
    const int half = side / 2;
    const auto corner = [&](int i) -> Eigen::Vector3i {
      return low + half * Eigen::Vector3i(i & 1, i >> 1 & 1, i >> 2 & 1);
    };
    for (int i = 0; i < 8; ++i) {
      const unsigned child = bits >> (2 * i) & 3;
      if (child == 1 || child == 2) visit_(Leaf{corner(i), half, child == 2});
    }
    for (int i = 0; i < 8; ++i) {
      if ((bits >> (2 * i) & 3) == 3) Walk(corner(i), half);
    }
  }

  std::string_view data_;
  const std::string& file_;
  const Visit& visit_;
  size_t at_ = 0;
};

template <typename Visit>
void ForEachLeaf(std::string_view data, const std::string& file, const Visit& visit) {
  Walker<Visit>(data, file, visit).Run();
}

// Keys around the free voxels, over those within the slice.
struct KeyBox {
  Eigen::Vector3i low = Eigen::Vector3i::Constant(1 << kDepth), high = Eigen::Vector3i::Zero();
};

// The keys of the slice: all when there is none.
std::pair<int, int> SliceKeys(const std::optional<Slice>& slice, double resolution) {
  if (!slice) return {0, 1 << kDepth};
  const double low = std::floor(slice->min / resolution + 1e-6) + kCenter;
  const double high = std::ceil(slice->max / resolution - 1e-6) + kCenter;
  const auto key = [](double k) { return static_cast<int>(std::clamp<double>(k, 0, 1 << kDepth)); };
  return {key(low), key(high)};
}

// Paints a leaf's voxels into the grid; what is occupied stays so.
void Paint(const Leaf& leaf, const KeyBox& box, CellGrid* grid) {
  Eigen::Vector3i low = (leaf.low - box.low).cwiseMax(0);
  Eigen::Vector3i high = ((leaf.low - box.low).array() + leaf.side).matrix().cwiseMin(grid->size);
  if (grid->dimension == 2) {
    low.z() = 0;
    high.z() = 1;
  }
  for (int z = low.z(); z < high.z(); ++z) {
    for (int y = low.y(); y < high.y(); ++y) {
      for (int x = low.x(); x < high.x(); ++x) {
        Cell& cell = grid->cells[grid->Index(x, y, z)];
        if (cell != Cell::kOccupied) cell = leaf.occupied ? Cell::kOccupied : Cell::kFree;
      }
    }
  }
}

}  // namespace

CellGrid ReadOctomap(std::string_view bytes, const std::string& file, const std::optional<Slice>& slice,
                     int64_t max_cells, bool unknown_is_free) {
  const Header header = ParseHeader(bytes, file);
  if (!(header.resolution >= kMinCellSize && header.resolution <= kMaxCellSize)) {
    ThrowUsageError("{}: res = {} m a voxel; it must be from {} to {}", file, header.resolution, kMinCellSize,
                    kMaxCellSize);
  }
  const std::string_view data = bytes.substr(header.data);
  const auto [slice_low, slice_high] = SliceKeys(slice, header.resolution);
  const auto in_slice = [low = slice_low, high = slice_high](const Leaf& leaf) {
    return leaf.low.z() < high && leaf.low.z() + leaf.side > low;
  };
  KeyBox box;
  ForEachLeaf(data, file, [&](const Leaf& leaf) {
    if ((leaf.occupied && !unknown_is_free) || !in_slice(leaf)) return;
    box.low = box.low.cwiseMin(leaf.low);
    box.high = box.high.cwiseMax((leaf.low.array() + leaf.side).matrix());
  });
  if ((box.high - box.low).minCoeff() <= 0) {
    ThrowUsageError("{}: no voxel{} is {}", file, slice ? " of the slice" : "", unknown_is_free ? "known" : "free");
  }
  if (!unknown_is_free) {  // a margin, so that walls around the free voxels show
    box.low = (box.low.array() - 1).cwiseMax(0);
    box.high = (box.high.array() + 1).cwiseMin(1 << kDepth);
  }
  CellGrid grid;
  grid.dimension = slice ? 2 : 3;
  grid.cell = header.resolution;
  grid.size = box.high - box.low;
  grid.origin = grid.cell * (box.low.array() - kCenter).matrix().cast<double>();
  if (slice) {
    grid.size.z() = 1;
    grid.origin.z() = 0;
  }
  CheckGrid(file, grid.size.cast<double>(), grid.cell, grid.origin, max_cells);
  grid.cells.assign(static_cast<size_t>(grid.size.x()) * grid.size.y() * grid.size.z(), Cell::kUnknown);
  ForEachLeaf(data, file, [&](const Leaf& leaf) {
    if (in_slice(leaf)) Paint(leaf, box, &grid);
  });
  return grid;
}

}  // namespace cairn
