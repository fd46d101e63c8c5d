#pragma once

#include <string>
#include <string_view>

#include "common/world/import/cell_grid.h"

namespace cairn {

/// A Moving AI benchmark map (type octile): '.', 'G' and 'S' are free, '@', 'O', 'T' and 'W' occupied. The format has
/// no metres: cells have side `cell` [m], the lower left corner of the last row lies at the origin, the first row on
/// top. Throws UsageError "file:line: …".
CellGrid ReadMovingAi(std::string_view text, const std::string& file, double cell, int64_t max_cells);

}  // namespace cairn
