#pragma once

#include <optional>

#include "common/core/bytes.h"
#include "common/roadmap/roadmap.h"

namespace cairn {

// Roadmaps and tables travel as blobs of little-endian numbers, named by the content hash of their bytes.

/// Vertex positions of a roadmap: {dimension i32, vertices i32, bends i32, positions f32[V × dimension]}.
Bytes PackPositions(const Roadmap& roadmap);
/// Only `dimension`, `num_bends` and `positions` are filled; nullopt when sizes or numbers are not sound.
std::optional<Roadmap> UnpackPositions(ByteSpan blob);

/// A cost table: {roadmap hash u64, goal f64[6], vertices i32, cost f32[V], next_vertex i32[V], mark reach f32, marks
/// i32, positions of marks f32[3 × marks]}.
Bytes PackTable(const CostTable& table);
/// nullopt when sizes do not agree, a cost is negative or NaN, or a next vertex is out of range.
std::optional<CostTable> UnpackTable(ByteSpan blob);

}  // namespace cairn
