#pragma once

#include <vector>

#include "common/roadmap/roadmap.h"
#include "planner/cost_to_go.h"

namespace cairn::planner {

/// Whether the lengths of a roadmap's edges, but for blocked ones (kUnreachable), differ so little, by up to √3 as on a
/// lattice, that BucketPaths pays.
bool SuitsBuckets(const Roadmap& roadmap);

/// Shortest paths to several sources at once with buckets in the place of a heap (Dial 1969; Denardo and Fox 1979):
/// with buckets no wider than the shortest edge, the order within one does not matter. Linear in edges, summed in
/// double: maps have millions of cells, on ways of which floats would round thousands of times the same way. The result
/// depends on the graph alone. Throws Error for a roadmap that does not suit.
ShortestPaths BucketPaths(const Roadmap& roadmap, const std::vector<int32_t>& sources);

}  // namespace cairn::planner
