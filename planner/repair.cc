#include "planner/repair.h"

#include "common/core/check.h"
#include "planner/collision/segment_distance.h"

namespace cairn::planner {
namespace {

float LongestEdge(const Roadmap& roadmap) {
  float longest = 0;
  for (const float length : roadmap.lengths) longest = length > longest && length < kUnreachable ? length : longest;
  return longest;
}

// What bounding boxes say: the segment p–q stays farther than `radius` from the box.
bool Apart(const Box& box, const Vector3d& p, const Vector3d& q, double radius) {
  return (p.cwiseMin(q).array() > box.max.array() + radius).any() ||
         (p.cwiseMax(q).array() < box.min.array() - radius).any();
}

}  // namespace

// An edge that touches a mark has both ends within its length of it, so few vertices are looked at. Both entries of an
// edge are judged with the same ends in the same order, hence alike.
int BlockEdges(const std::vector<Box>& marks, double radius, Roadmap* roadmap) {
  CAIRN_CHECK(radius >= 0, "radius {}", radius);
  const double reach = radius + LongestEdge(*roadmap);
  int cut = 0;
  for (Box mark : marks) {
    if (roadmap->dimension == 2) mark.min.z() = mark.max.z() = 0;
    for (int32_t v = 0; v < roadmap->num_vertices(); ++v) {
      const Vector3d p = roadmap->position(v);
      if (Excess(mark, p).squaredNorm() > reach * reach) continue;
      for (int32_t e = roadmap->offsets[v]; e < roadmap->offsets[v + 1]; ++e) {
        const int32_t other = roadmap->neighbors[e];
        float& length = roadmap->lengths[e];
        if (length == kUnreachable) continue;
        const Vector3d q = roadmap->position(other);
        if (Apart(mark, p, q, radius)) continue;
        if (SegmentDistance(mark, v < other ? p : q, v < other ? q : p) > radius) continue;
        length = kUnreachable;
        ++cut;
      }
    }
  }
  return cut / 2;
}

}  // namespace cairn::planner
