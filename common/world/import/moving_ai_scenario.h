#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

/// One path query of a scenario. Cells are counted from the map's upper left corner, x to the right, y down.
struct ScenarioPath {
  int line = 0;  ///< of the file, from 1
  std::array<int, 2> start{}, goal{};
  double length = 0;  ///< published shortest length [cells]
};

/// A Moving AI benchmark scenario: path queries on one map.
struct Scenario {
  std::string map;  ///< file name as written, with folders if it has them
  int width = 0, height = 0;
  std::vector<ScenarioPath> paths;
  bool ends_in_line = true;  ///< false: the last line has no end, so its last number may be torn
};

/// Reads a .scen file, format version 1: `bucket map width height start-x start-y goal-x goal-y length` a line. Throws
/// UsageError "file:line: …": a torn or odd line, a cell outside the map, lines of different maps, no path at all.
Scenario ReadScenario(std::string_view text, const std::string& file);

}  // namespace cairn
