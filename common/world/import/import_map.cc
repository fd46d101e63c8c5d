#include "common/world/import/import_map.h"

#include <algorithm>
#include <filesystem>

#include "common/core/check.h"
#include "common/core/files.h"
#include "common/core/hash.h"
#include "common/world/import/cell_grid.h"
#include "common/world/import/gazebo_world.h"
#include "common/world/import/moving_ai.h"
#include "common/world/import/octomap.h"
#include "common/world/import/ros_map.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr uintmax_t kMaxYamlBytes = 65536;    // a map_server file has seven lines
constexpr uintmax_t kMaxXmlBytes = 64 << 20;  // BARN's worlds have half a megabyte
constexpr uintmax_t kMaxBytes = uintmax_t{1} << 30;
constexpr int kMargin = 1;  // cells kept around the free ones, so that pictures show the walls

enum class Format { kRos, kOctomap, kMovingAi, kGazebo };

Format FormatOf(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending == ".yaml" || ending == ".yml") return Format::kRos;
  if (ending == ".bt") return Format::kOctomap;
  if (ending == ".map") return Format::kMovingAi;
  if (ending == ".world" || ending == ".sdf") return Format::kGazebo;
  std::string cure;
  if (ending == ".pgm" || ending == ".png") cure = "; give the .yaml file that names this image";
  if (ending == ".ot") cure = "; convert it: octomap's `convert_octree map.ot map.bt`";
  ThrowUsageError("{}: a map ends in .yaml (map_server), .bt (OctoMap), .map (Moving AI) or .world (Gazebo, BARN){}",
                  path, cure);
}

std::string ReadBounded(const std::string& path, uintmax_t max_bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) ThrowUsageError("{}: No such file", path);
  if (!fs::is_regular_file(status)) ThrowUsageError("{}: not a file", path);
  const uintmax_t size = fs::file_size(path, error);
  if (size > max_bytes) ThrowUsageError("{}: {} bytes; a map of this kind has at most {}", path, size, max_bytes);
  try {
    return ReadFile(path);
  } catch (const Error& unreadable) {
    throw UsageError(unreadable.what());
  }
}

std::string ImagePath(const std::string& yaml, const RosMapInfo& info) {
  return (fs::path(yaml).parent_path() / info.image).string();  // an absolute one stands for itself
}

CellGrid ReadRos(const std::string& path, int64_t max_cells) {
  const RosMapInfo info = ParseRosMapInfo(ReadBounded(path, kMaxYamlBytes), path);
  const std::string image = ImagePath(path, info);
  if (!fs::exists(image)) ThrowUsageError("{}: image = {}; there is no such file: {}", path, info.image, image);
  return ReadRosMap(info, ReadBounded(image, kMaxBytes), image, max_cells);
}

CellGrid ReadCells(Format format, const std::string& path, const MapOptions& options) {
  switch (format) {
    case Format::kOctomap:
      return ReadOctomap(ReadBounded(path, kMaxBytes), path, options.slice, options.max_cells, options.unknown_is_free);
    case Format::kMovingAi:
      return ReadMovingAi(ReadBounded(path, kMaxBytes), path, options.cell_size.value_or(1), options.max_cells);
    default:
      return ReadRos(path, options.max_cells);
  }
}

ImportedMap FromCells(CellGrid grid, const MapOptions& options, const std::string& path) {
  if (options.unknown_is_free) std::replace(grid.cells.begin(), grid.cells.end(), Cell::kUnknown, Cell::kFree);
  grid = CropToFree(std::move(grid), options.window, kMargin, path);
  ImportedMap map;
  map.dimension = grid.dimension;
  map.cell = grid.cell;
  for (int k = 0; k < grid.dimension; ++k) {
    map.bounds.min[k] = grid.origin[k];
    map.bounds.max[k] = grid.origin[k] + grid.cell * grid.size[k];
  }
  map.boxes = MergeBoxes(std::move(grid));
  return map;
}

void Include(const Vector3d& min, const Vector3d& max, Box* bounds) {
  bounds->min = bounds->min.cwiseMin(min);
  bounds->max = bounds->max.cwiseMax(max);
}

ImportedMap FromGazebo(const std::string& path, const MapOptions& options) {
  GazeboObstacles obstacles = ReadGazeboWorld(ReadBounded(path, kMaxXmlBytes), path, options.slice);
  ImportedMap map;
  map.boxes = std::move(obstacles.boxes);
  map.cylinders = std::move(obstacles.cylinders);
  for (Box& box : map.boxes) box.min.z() = box.max.z() = 0;
  for (Cylinder& cylinder : map.cylinders) cylinder.base.z() = cylinder.height = 0;
  if (map.boxes.empty() && map.cylinders.empty()) {
    ThrowUsageError("{}: no model has a cylinder or box{}", path, options.slice ? " within the slice" : "");
  }
  map.bounds = {Vector3d::Constant(kMaxCoordinate), Vector3d::Constant(-kMaxCoordinate)};
  for (const Box& box : map.boxes) Include(box.min, box.max, &map.bounds);
  for (const Cylinder& c : map.cylinders) {
    const Vector3d half(c.radius, c.radius, 0);
    Include(c.base - half, c.base + half, &map.bounds);
  }
  if (options.window) map.bounds = *options.window;
  map.bounds.min.z() = map.bounds.max.z() = 0;
  return map;
}

uint64_t HashOf(const ImportedMap& map) {
  std::vector<double> numbers{static_cast<double>(map.dimension), map.cell};
  const auto add = [&](const Vector3d& p) { numbers.insert(numbers.end(), p.data(), p.data() + 3); };
  add(map.bounds.min);
  add(map.bounds.max);
  for (const Cylinder& c : map.cylinders) {
    add(c.base);
    add(Vector3d(c.radius, c.height, 0));
  }
  const uint64_t hash = ContentHash(map.boxes.data(), map.boxes.size() * sizeof(Box));
  return ContentHash(numbers.data(), numbers.size() * sizeof(double), hash);
}

void CheckOptions(Format format, const MapOptions& options, const std::string& path) {
  if (options.cell_size && format != Format::kMovingAi) {
    ThrowUsageError("world.map_resolution = {} m: {} says its own sizes; it is for Moving AI maps", *options.cell_size,
                    path);
  }
  if (options.slice && (format == Format::kRos || format == Format::kMovingAi)) {
    ThrowUsageError("world.slice_min, world.slice_max: {} is a plane map; they are for .bt and .world files", path);
  }
}

}  // namespace

ImportedMap ImportMap(const std::string& path, const MapOptions& options) {
  const Format format = FormatOf(path);
  CheckOptions(format, options, path);
  ImportedMap map = format == Format::kGazebo ? FromGazebo(path, options)
                                              : FromCells(ReadCells(format, path, options), options, path);
  map.hash = HashOf(map);
  return map;
}

std::string CopyMap(const std::string& path, const std::string& directory) {
  const std::string copy = (fs::path(directory) / fs::path(path).filename()).string();
  if (FormatOf(path) != Format::kRos) {
    WriteFileAtomically(copy, ReadBounded(path, kMaxBytes));
    return copy;
  }
  const RosMapInfo info = ParseRosMapInfo(ReadBounded(path, kMaxYamlBytes), path);
  const fs::path image = ImagePath(path, info);
  const std::string name = "image" + image.extension().string();  // a file's own may be no text at all
  WriteFileAtomically((fs::path(directory) / name).string(), ReadBounded(image.string(), kMaxBytes));
  WriteFileAtomically(copy, PrintRosMapInfo(info, name));
  return copy;
}

}  // namespace cairn
