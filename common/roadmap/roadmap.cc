#include "common/roadmap/roadmap.h"

#include <algorithm>
#include <cmath>

#include "common/core/hash.h"
#include "common/roadmap/roadmap_blob.h"

namespace cairn {
namespace {

uint64_t HashOf(const Bytes& blob) { return ContentHash(blob.data(), blob.size()); }

}  // namespace

Vector3d Roadmap::position(int vertex) const {
  const float* p = positions.data() + static_cast<size_t>(vertex) * dimension;
  return Vector3d(p[0], p[1], dimension == 3 ? p[2] : 0.0f);
}

uint64_t Roadmap::Hash() const { return HashOf(PackPositions(*this)); }

float CostTable::max_cost() const {
  float longest = 0;
  for (const float c : cost) {
    if (std::isfinite(c)) longest = std::max(longest, c);
  }
  return longest;
}

uint64_t CostTable::Hash() const { return HashOf(PackTable(*this)); }

}  // namespace cairn
