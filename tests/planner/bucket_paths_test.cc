#include "planner/bucket_paths.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/check.h"
#include "tests/planner/brute_force.h"

namespace cairn::planner {
namespace {

// The 8-connected free cells of a grid, all cells as vertices.
Roadmap RoadmapOf(const CellGrid& grid, double cell) {
  Roadmap roadmap;
  roadmap.offsets.push_back(0);
  const auto free = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < grid.size.x() && y < grid.size.y() && grid.cells[grid.Index(x, y)] == Cell::kFree;
  };
  for (int y = 0; y < grid.size.y(); ++y) {
    for (int x = 0; x < grid.size.x(); ++x) {
      for (const float coordinate : {x * cell, y * cell}) roadmap.positions.push_back(coordinate);
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const bool step =
              (dx != 0 || dy != 0) && free(x, y) && free(x + dx, y) && free(x, y + dy) && free(x + dx, y + dy);
          if (!step) continue;
          roadmap.neighbors.push_back((y + dy) * grid.size.x() + x + dx);
          roadmap.lengths.push_back(static_cast<float>(cell * std::hypot(dx, dy)));
        }
      }
      roadmap.offsets.push_back(static_cast<int32_t>(roadmap.neighbors.size()));
    }
  }
  return roadmap;
}

TEST(BucketPathsTest, AgreesWithTheHeapAndNextVerticesLeadThere) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const CellGrid grid = RandomCells({40, 30, 1}, 0.3, seed);
    const Roadmap roadmap = RoadmapOf(grid, 0.05);
    const std::vector<int32_t> sources{5, 700, 701};
    const ShortestPaths heap = ComputeShortestPaths(roadmap, sources), buckets = BucketPaths(roadmap, sources);
    for (int v = 0; v < roadmap.num_vertices(); ++v) {
      ASSERT_EQ(std::isfinite(buckets.cost[v]), std::isfinite(heap.cost[v]));
      if (!std::isfinite(heap.cost[v])) continue;
      ASSERT_NEAR(buckets.cost[v], heap.cost[v], 1e-5);
      const int32_t next = buckets.next_vertex[v];
      if (next < 0) {
        ASSERT_EQ(buckets.cost[v], 0);
        continue;
      }
      const double step = (roadmap.position(v) - roadmap.position(next)).norm();
      ASSERT_NEAR(buckets.cost[v], buckets.cost[next] + step, 1e-6);
    }
  }
}

// In floats each of these sums is rounded the same way: 0.17 m too short.
TEST(BucketPathsTest, LongWaysAreSummedInDouble) {
  const Roadmap roadmap = RoadmapOf(RandomCells({20000, 1, 1}, 0, 1), 0.05);
  const ShortestPaths paths = BucketPaths(roadmap, {0});
  EXPECT_NEAR(paths.cost[19999], 19999 * 0.05, 1e-4);
}

TEST(BucketPathsTest, BlockedEdgesAreNoWay) {
  Roadmap roadmap = RoadmapOf(RandomCells({4, 1, 1}, 0, 1), 1);
  roadmap.lengths[1] = roadmap.lengths[2] = kUnreachable;  // 1 → 0, 1 → 2
  roadmap.lengths[0] = roadmap.lengths[3] = kUnreachable;
  const ShortestPaths paths = BucketPaths(roadmap, {3});
  EXPECT_EQ(paths.cost, (std::vector<float>{kUnreachable, kUnreachable, 1, 0}));
}

TEST(BucketPathsTest, LengthsThatDifferTooMuchDoNotSuit) {
  Roadmap roadmap = RoadmapOf(RandomCells({3, 1, 1}, 0, 1), 1);
  EXPECT_TRUE(SuitsBuckets(roadmap));
  roadmap.lengths[0] = roadmap.lengths[1] = 1.8f;
  EXPECT_FALSE(SuitsBuckets(roadmap));
  EXPECT_THROW(BucketPaths(roadmap, {0}), Error);
  roadmap.lengths[0] = 0;
  EXPECT_FALSE(SuitsBuckets(roadmap));
}

}  // namespace
}  // namespace cairn::planner
