#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/world/import/cell_grid.h"

namespace cairn {

/// An OctoMap binary tree (.bt). Without a slice the voxels around its free ones; with it a plane map: a cell is
/// occupied when a voxel within the slice is, else free when one is free, else unknown (as octomap_server projects).
/// With `unknown_is_free` the voxels around all that the tree knows: one may hold occupied voxels only.
/// Own reader: octomap's recurses as deep as the file says and goes on with what it could not read. Throws UsageError
/// naming `file` and what is wrong.
CellGrid ReadOctomap(std::string_view bytes, const std::string& file, const std::optional<Slice>& slice,
                     int64_t max_cells, bool unknown_is_free = false);

}  // namespace cairn
