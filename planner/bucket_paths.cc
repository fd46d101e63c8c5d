#include "planner/bucket_paths.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/core/check.h"

namespace cairn::planner {
namespace {

constexpr double kLargestRatio = 1.7321;  // √3, and what floats round

// A ring of lists of vertices by cost; the one that is open next is the cheapest.
class Buckets {
 public:
  Buckets(double width, double longest) : width_(width), ring_(static_cast<size_t>(longest / width) + 2) {}

  void Add(double cost, int32_t vertex) {
    ring_[static_cast<size_t>(cost / width_) % ring_.size()].push_back(vertex);
    ++size_;
  }

  // Replaces `vertices` by those of the next bucket; false when all are empty.
  bool Take(std::vector<int32_t>* vertices) {
    vertices->clear();
    if (size_ == 0) return false;
    for (; vertices->empty(); at_ = (at_ + 1) % ring_.size()) ring_[at_].swap(*vertices);
    size_ -= vertices->size();
    return true;
  }

 private:
  double width_;  // [m]
  std::vector<std::vector<int32_t>> ring_;
  size_t at_ = 0, size_ = 0;
};

// Of the edges that are open.
std::pair<float, float> Extremes(const Roadmap& roadmap) {
  float shortest = kUnreachable, longest = 0;
  for (const float length : roadmap.lengths) {
    if (length == kUnreachable) continue;
    shortest = std::min(shortest, length);
    longest = std::max(longest, length);
  }
  return longest > 0 ? std::pair(shortest, longest) : std::pair(1.0f, 1.0f);
}

}  // namespace

bool SuitsBuckets(const Roadmap& roadmap) {
  const auto [shortest, longest] = Extremes(roadmap);
  return shortest > 0 && longest <= kLargestRatio * shortest;
}

ShortestPaths BucketPaths(const Roadmap& roadmap, const std::vector<int32_t>& sources) {
  if (!SuitsBuckets(roadmap)) ThrowError("bucket paths: the edges' lengths differ too much");
  const auto vertices = static_cast<size_t>(roadmap.num_vertices());
  const auto [shortest, longest] = Extremes(roadmap);
  Buckets buckets(0.999 * shortest, longest);  // a rounded sum must not fall back into the bucket it came from
  std::vector<double> cost(vertices, std::numeric_limits<double>::infinity());
  std::vector<char> done(vertices, 0);
  ShortestPaths paths{{}, std::vector<int32_t>(vertices, -1)};
  for (const int32_t source : sources) {
    cost[source] = 0;
    buckets.Add(0, source);
  }
  for (std::vector<int32_t> taken; buckets.Take(&taken);) {
    for (const int32_t vertex : taken) {
      if (std::exchange(done[vertex], 1)) continue;
      for (int32_t e = roadmap.offsets[vertex]; e < roadmap.offsets[vertex + 1]; ++e) {
        const int32_t neighbor = roadmap.neighbors[e];
        const double through = cost[vertex] + roadmap.lengths[e];
        if (!(through < cost[neighbor])) continue;
        cost[neighbor] = through;
        paths.next_vertex[neighbor] = vertex;
        buckets.Add(through, neighbor);
      }
    }
  }
  paths.cost.assign(cost.begin(), cost.end());
  return paths;
}

}  // namespace cairn::planner
