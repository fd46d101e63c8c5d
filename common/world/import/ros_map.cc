#include "common/world/import/ros_map.h"

#include <yaml-cpp/yaml.h>

#include <cmath>

#include "common/core/check.h"
#include "common/world/import/map_image.h"

namespace cairn {
namespace {

constexpr const char* kModes[] = {"trinary", "scale", "raw"};

// Reads keys of a yaml map and names file, line and key in errors.
class YamlKeys {
 public:
  YamlKeys(const std::string& text, const std::string& file) : file_(file) {
    try {
      root_ = YAML::Load(text);
    } catch (const YAML::Exception& error) {
      ThrowUsageError("{}:{}: not YAML: {}", file, error.mark.line + 1, error.msg);
    }
    if (!root_.IsMap()) ThrowUsageError("{}: a map_server file is a list of `key: value` lines", file);
  }

  bool Has(const char* key) const { return root_[key].IsDefined(); }

  std::string Text(const char* key) const {
    const YAML::Node node = Node(key);
    if (!node.IsScalar() || node.Scalar().empty()) Throw(node, key, "it must be a text");
    return node.Scalar();
  }

  double Number(const char* key, const char* rule) const { return Number(Node(key), key, rule); }

  Vector3d Triple(const char* key) const {
    const YAML::Node node = Node(key);
    constexpr const char* kRule = "it must be [x, y, yaw], metres and radians";
    if (!node.IsSequence() || node.size() != 3) Throw(node, key, kRule);
    return {Number(node[0], key, kRule), Number(node[1], key, kRule), Number(node[2], key, kRule)};
  }

  bool Flag(const char* key) const {
    const YAML::Node node = Node(key);
    const std::string& text = node.IsScalar() ? node.Scalar() : "";
    if (text == "1" || text == "true" || text == "True") return true;
    if (text == "0" || text == "false" || text == "False") return false;
    Throw(node, key, "it must be 0 or 1");
  }

  [[noreturn]] void Throw(const char* key, const std::string& rule) const { Throw(Node(key), key, rule); }

 private:
  YAML::Node Node(const char* key) const {
    const YAML::Node node = root_[key];
    if (!node.IsDefined()) ThrowUsageError("{}: {} is missing", file_, key);
    return node;
  }

  double Number(const YAML::Node& node, const char* key, const char* rule) const {
    double value = 0;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
      Throw(node, key, rule);
    }
    return value;
  }

  [[noreturn]] void Throw(const YAML::Node& node, const char* key, const std::string& rule) const {
    const std::string value = node.IsScalar() ? " = " + node.Scalar().substr(0, 80) : "";
    ThrowUsageError("{}:{}: {}{}; {}", file_, node.Mark().line + 1, key, value, rule);
  }

  const std::string& file_;
  YAML::Node root_;
};

RosMapInfo::Mode ParseMode(const YamlKeys& keys) {
  if (!keys.Has("mode")) return RosMapInfo::Mode::kTrinary;
  const std::string text = keys.Text("mode");
  for (int i = 0; i < 3; ++i) {
    if (text == kModes[i]) return static_cast<RosMapInfo::Mode>(i);
  }
  keys.Throw("mode", "it must be trinary, scale or raw");
}

class CellSink : public ImageSink {
 public:
  CellSink(const RosMapInfo& info, const std::string& file, int64_t max_cells)
      : info_(info), file_(file), max_cells_(max_cells) {}

  void Begin(int64_t width, int64_t height, bool has_alpha) override {
    has_alpha_ = has_alpha;
    const Vector3d origin(info_.origin.x(), info_.origin.y(), 0);
    CheckGrid(file_, Vector3d(static_cast<double>(width), static_cast<double>(height), 1), info_.resolution, origin,
              max_cells_);
    grid_.size = {static_cast<int>(width), static_cast<int>(height), 1};
    grid_.cell = info_.resolution;
    grid_.origin = origin;
    grid_.cells.resize(static_cast<size_t>(width * height));
  }

  void Row(int64_t y, const Pixel* pixels) override {
    Cell* row = grid_.cells.data() + grid_.Index(0, grid_.size.y() - 1 - static_cast<int>(y));
    for (int x = 0; x < grid_.size.x(); ++x) row[x] = Classify(pixels[x]);
  }

  CellGrid TakeGrid() { return std::move(grid_); }

 private:
  Cell Classify(const Pixel& pixel) const {
    double sum = pixel.red + pixel.green + pixel.blue, channels = 3;
    if (info_.mode == RosMapInfo::Mode::kTrinary && has_alpha_) {  // map_server averages alpha in
      sum += pixel.alpha;
      ++channels;
    }
    if (info_.mode == RosMapInfo::Mode::kScale && pixel.alpha < 255) return Cell::kUnknown;
    double p = sum / (channels * 255);
    if (info_.mode == RosMapInfo::Mode::kRaw) {
      const double percent = std::round(p * 255);
      if (percent > 100) return Cell::kUnknown;
      p = percent / 100;
    } else if (!info_.negate) {
      p = 1 - p;
    }
    return p > info_.occupied_thresh ? Cell::kOccupied : p < info_.free_thresh ? Cell::kFree : Cell::kUnknown;
  }

  const RosMapInfo& info_;
  const std::string& file_;
  int64_t max_cells_;
  bool has_alpha_ = false;
  CellGrid grid_;
};

}  // namespace

RosMapInfo ParseRosMapInfo(const std::string& text, const std::string& file) {
  try {
    const YamlKeys keys(text, file);
    constexpr const char* kThreshold = "it must be a number from 0 to 1";
    RosMapInfo info;
    info.image = keys.Text("image");
    info.mode = ParseMode(keys);
    info.resolution = keys.Number("resolution", "it must be a number, metres a pixel");
    if (!(info.resolution >= kMinCellSize && info.resolution <= kMaxCellSize)) {
      keys.Throw("resolution", fmt::format("it must be from {} to {}: metres a pixel, not centimetres or millimetres",
                                           kMinCellSize, kMaxCellSize));
    }
    info.origin = keys.Triple("origin");
    if (std::abs(info.origin.z()) > 100) keys.Throw("origin", "its third number is the yaw, in radians");
    info.negate = keys.Flag("negate");
    info.occupied_thresh = keys.Number("occupied_thresh", kThreshold);
    info.free_thresh = keys.Number("free_thresh", kThreshold);
    if (!(info.occupied_thresh >= 0 && info.occupied_thresh <= 1)) keys.Throw("occupied_thresh", kThreshold);
    if (!(info.free_thresh >= 0 && info.free_thresh <= 1)) keys.Throw("free_thresh", kThreshold);
    if (info.occupied_thresh < info.free_thresh) {
      keys.Throw("occupied_thresh", fmt::format("it must not be less than free_thresh = {}", info.free_thresh));
    }
    return info;
  } catch (const YAML::Exception& error) {
    ThrowUsageError("{}:{}: {}", file, error.mark.line + 1, error.msg);
  }
}

std::string PrintRosMapInfo(const RosMapInfo& info, const std::string& image) {
  return fmt::format(
      "image: {}\nmode: {}\nresolution: {}\norigin: [{}, {}, {}]\nnegate: {}\noccupied_thresh: {}\nfree_thresh: {}\n",
      image, kModes[static_cast<int>(info.mode)], info.resolution, info.origin.x(), info.origin.y(), info.origin.z(),
      info.negate ? 1 : 0, info.occupied_thresh, info.free_thresh);
}

CellGrid ReadRosMap(const RosMapInfo& info, std::string_view image, const std::string& image_file, int64_t max_cells) {
  CellSink sink(info, image_file, max_cells);
  const bool png = image_file.ends_with(".png") || image_file.ends_with(".PNG");
  const bool pgm = image_file.ends_with(".pgm") || image_file.ends_with(".PGM");
  if (!png && !pgm) ThrowUsageError("{}: image: only .pgm and .png are read; convert it to one of them", image_file);
  png ? ReadPng(image, image_file, &sink) : ReadPgm(image, image_file, &sink);
  const CellGrid grid = sink.TakeGrid();
  return info.origin.z() == 0 ? grid : Rotate(grid, info.origin.z(), image_file, max_cells);
}

}  // namespace cairn
