#include "common/roadmap/roadmap.h"

#include <algorithm>
#include <cmath>

#include "common/core/hash.h"

namespace cairn {
namespace {

template <typename T>
uint64_t HashVector(const std::vector<T>& values, uint64_t seed) {
  const uint64_t size = values.size();
  return ContentHash(values.data(), size * sizeof(T), ContentHash(&size, sizeof(size), seed));
}

}  // namespace

Vector3d Roadmap::position(int vertex) const {
  const float* p = positions.data() + static_cast<size_t>(vertex) * dimension;
  return Vector3d(p[0], p[1], dimension == 3 ? p[2] : 0.0f);
}

uint64_t Roadmap::Hash() const { return HashVector(positions, static_cast<uint64_t>(dimension)); }

float CostTable::max_cost() const {
  float longest = 0;
  for (const float c : cost) {
    if (std::isfinite(c)) longest = std::max(longest, c);
  }
  return longest;
}

uint64_t CostTable::Hash() const {
  const double region[6] = {goal.min.x(), goal.min.y(), goal.min.z(), goal.max.x(), goal.max.y(), goal.max.z()};
  return HashVector(next_vertex, HashVector(cost, ContentHash(region, sizeof(region), roadmap_hash)));
}

}  // namespace cairn
