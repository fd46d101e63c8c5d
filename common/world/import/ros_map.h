#pragma once

#include <string>
#include <string_view>

#include "common/world/import/cell_grid.h"

namespace cairn {

/// The keys of a map_server yaml file; all but `mode` must be there, others are ignored.
struct RosMapInfo {
  enum class Mode { kTrinary, kScale, kRaw };
  std::string image;  ///< as written: relative to the yaml file
  Mode mode = Mode::kTrinary;
  double resolution = 0;  ///< [m] a pixel
  Vector3d origin;        ///< x, y [m] and yaw [rad] of the image's lower left corner in the map's frame
  bool negate = false;
  double occupied_thresh = 0;
  double free_thresh = 0;
};

/// Throws UsageError "file:line: key: …".
RosMapInfo ParseRosMapInfo(const std::string& text, const std::string& file);

/// The yaml text that ParseRosMapInfo reads back to the same, with another image, a plain file name.
std::string PrintRosMapInfo(const RosMapInfo& info, const std::string& image);

/// The cells of an image (.pgm or .png by its name) as map_server's `mode` reads it: p = 1 − shade (negate: shade),
/// occupied above occupied_thresh, free below free_thresh, else unknown. `scale` differs in pixels that are not opaque:
/// unknown. `raw`: the pixel's value is p in per cent, above 100 unknown. W is the map's frame: a yaw turns the cells.
CellGrid ReadRosMap(const RosMapInfo& info, std::string_view image, const std::string& image_file, int64_t max_cells);

}  // namespace cairn
