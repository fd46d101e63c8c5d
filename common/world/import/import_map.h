#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/world/import/cell_grid.h"
#include "common/world/world.h"

namespace cairn {

/// How a map file is to be read.
struct MapOptions {
  bool unknown_is_free = false;
  std::optional<double> cell_size;  ///< [m]; only for Moving AI, which states none; none: 1
  std::optional<Slice> slice;       ///< for maps in space: makes a plane one of what stands between these heights
  std::optional<Box> window;        ///< reads only this part of the map; a Gazebo world takes it as its bounds
  int64_t max_cells = int64_t{1} << 27;
};

/// What a map file holds, as obstacles in W, which is the map's own frame. Immutable once made.
struct ImportedMap {
  int dimension = 2;
  double cell = 0;  ///< side of its cells [m]; obstacles stand on whole ones; 0: it has none
  Box bounds;       ///< around the free space; everything outside is occupied
  std::vector<Box> boxes;
  std::vector<Cylinder> cylinders;
  uint64_t hash = 0;  ///< of all the above: what the map says, not how its file is written
};

/// Reads a map by its file's ending: .yaml (map_server), .bt (OctoMap), .map (Moving AI), .world (Gazebo, BARN).
/// Unknown cells are occupied unless told otherwise. Memory is bounded by the file and max_cells. Throws UsageError
/// naming the file, the field or line, and the rule.
ImportedMap ImportMap(const std::string& path, const MapOptions& options = {});

/// Writes a copy of the map, with its image if it has one, into `directory` and returns the path of the copy's map
/// file, which imports to the same. Throws Error when it cannot be written.
std::string CopyMap(const std::string& path, const std::string& directory);

}  // namespace cairn
