#include "common/world/import/gazebo_world.h"

#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <pugixml.hpp>

#include "common/core/check.h"
#include "common/world/import/cell_grid.h"

namespace cairn {
namespace {

constexpr double kTiltTolerance = 1e-6;  // [rad]

// x, y, z [m] and roll, pitch, yaw [rad]: SDF's pose; only the yaw may turn what we keep.
struct SdfPose {
  Vector3d position = Vector3d::Zero();
  double tilt = 0;  // largest of |roll|, |pitch|
  double yaw = 0;
};

SdfPose operator*(const SdfPose& a, const SdfPose& b) {
  const double c = std::cos(a.yaw), s = std::sin(a.yaw);
  const Vector3d turned(c * b.position.x() - s * b.position.y(), s * b.position.x() + c * b.position.y(),
                        b.position.z());
  return {a.position + turned, std::max(a.tilt, b.tilt), a.yaw + b.yaw};
}

class WorldReader {
 public:
  WorldReader(const std::string& file, const std::optional<Slice>& slice) : file_(file), slice_(slice) {}

  GazeboObstacles Read(const pugi::xml_document& document) {
    const pugi::xml_node world = document.child("sdf").child("world");
    if (!world) ThrowUsageError("{}: not a Gazebo world: there is no <sdf><world>", file_);
    std::map<std::string, SdfPose> poses;
    for (const pugi::xml_node model : world.child("state").children("model")) {
      if (model.child("pose")) poses[model.attribute("name").value()] = ReadPose(model, Name(model));
    }
    if (world.child("include"))
      ThrowUsageError("{}: <include> of other files is not read; save the world whole", file_);
    for (const pugi::xml_node model : world.children("model")) {
      const auto found = poses.find(model.attribute("name").value());
      ReadModel(model, found == poses.end() ? ReadPose(model, Name(model)) : found->second);
    }
    return std::move(obstacles_);
  }

 private:
  static std::string Name(const pugi::xml_node& model) {
    return std::string(model.attribute("name").value()).substr(0, 80);
  }

  // `count` numbers of a node's text.
  std::vector<double> Numbers(const pugi::xml_node& node, size_t count, const std::string& model) const {
    const std::string_view text = node.child_value();
    std::vector<double> numbers;
    for (size_t at = 0; numbers.size() <= count;) {
      at = text.find_first_not_of(" \t\r\n", at);
      if (at == std::string_view::npos) break;
      if (text[at] == '+') ++at;
      double value = 0;
      const auto [end, error] = std::from_chars(text.data() + at, text.data() + text.size(), value);
      if (error != std::errc() || !std::isfinite(value)) break;
      numbers.push_back(value);
      at = static_cast<size_t>(end - text.data());
    }
    if (numbers.size() != count) {
      ThrowUsageError("{}: model {}: <{}> \"{}\"; it must be {} finite number{}", file_, model, node.name(),
                      text.substr(0, 60), count, count == 1 ? "" : "s");
    }
    return numbers;
  }

  SdfPose ReadPose(const pugi::xml_node& parent, const std::string& model) const {
    const pugi::xml_node node = parent.child("pose");
    if (!node) return {};
    const std::string relative = node.attribute("relative_to").value();
    if (!relative.empty()) {
      ThrowUsageError("{}: model {}: <pose relative_to='{}'> is not read", file_, model, relative.substr(0, 40));
    }
    const std::vector<double> p = Numbers(node, 6, model);
    return {Vector3d(p[0], p[1], p[2]), std::max(std::abs(p[3]), std::abs(p[4])), p[5]};
  }

  void ReadModel(const pugi::xml_node& model, const SdfPose& pose) {
    const std::string name = Name(model);
    if (model.child("include") || model.child("model")) {
      ThrowUsageError("{}: model {}: models within models are not read", file_, name);
    }
    for (const pugi::xml_node link : model.children("link")) {
      const SdfPose link_pose = pose * ReadPose(link, name);
      for (const pugi::xml_node collision : link.children("collision")) {
        ReadShape(collision.child("geometry"), link_pose * ReadPose(collision, name), name);
      }
    }
  }

  void ReadShape(const pugi::xml_node& geometry, const SdfPose& pose, const std::string& name) {
    const pugi::xml_node shape = geometry.first_child();
    const std::string kind = shape.name();
    if (kind == "plane") return;
    if (kind != "cylinder" && kind != "box") {
      ThrowUsageError("{}: model {}: a collision shape <{}>; only cylinders, boxes and the ground's plane are read",
                      file_, name, kind.substr(0, 40));
    }
    if (pose.tilt > kTiltTolerance)
      ThrowUsageError("{}: model {}: it is tilted; obstacles must be upright", file_, name);
    kind == "cylinder" ? AddCylinder(shape, pose, name) : AddBox(shape, pose, name);
  }

  double Length(const pugi::xml_node& shape, const char* field, const std::string& name) const {
    const double value = Numbers(shape.child(field), 1, name)[0];
    if (!(value > 0 && value <= kMaxCoordinate)) ThrowLength(field, value, name);
    return value;
  }

  [[noreturn]] void ThrowLength(const char* field, double value, const std::string& name) const {
    ThrowUsageError("{}: model {}: {} = {} m; it must be above 0 and at most {}", file_, name, field, value,
                    kMaxCoordinate);
  }

  void CheckPosition(const Vector3d& p, const std::string& name) const {
    if (p.cwiseAbs().maxCoeff() <= kMaxCoordinate) return;
    ThrowUsageError("{}: model {}: it stands at ({}, {}, {}) m; coordinates must stay within ±{:.0f} m", file_, name,
                    p.x(), p.y(), p.z(), kMaxCoordinate);
  }

  bool InSlice(double low, double high) const { return !slice_ || (high > slice_->min && low < slice_->max); }

  void AddCylinder(const pugi::xml_node& shape, const SdfPose& pose, const std::string& name) {
    const double radius = Length(shape, "radius", name), height = Length(shape, "length", name);
    CheckPosition(pose.position, name);
    const Vector3d base = pose.position - Vector3d(0, 0, 0.5 * height);
    if (!InSlice(base.z(), base.z() + height)) return;
    obstacles_.cylinders.push_back({base, radius, height});
  }

  void AddBox(const pugi::xml_node& shape, const SdfPose& pose, const std::string& name) {
    const std::vector<double> size = Numbers(shape.child("size"), 3, name);
    CheckPosition(pose.position, name);
    Vector3d half(0.5 * size[0], 0.5 * size[1], 0.5 * size[2]);
    for (const double side : size) {
      if (!(side > 0 && side <= kMaxCoordinate)) ThrowLength("size", side, name);
    }
    const double turns = pose.yaw / (0.5 * std::numbers::pi);
    if (std::abs(turns - std::round(turns)) > kTiltTolerance) {
      ThrowUsageError("{}: model {}: a box turned by {:.4g} rad; boxes must stand along the axes (quarter turns)",
                      file_, name, pose.yaw);
    }
    if (std::fmod(std::abs(std::round(turns)), 2) == 1) std::swap(half.x(), half.y());
    if (!InSlice(pose.position.z() - half.z(), pose.position.z() + half.z())) return;
    obstacles_.boxes.push_back({pose.position - half, pose.position + half});
  }

  const std::string& file_;
  const std::optional<Slice>& slice_;
  GazeboObstacles obstacles_;
};

}  // namespace

GazeboObstacles ReadGazeboWorld(std::string_view text, const std::string& file, const std::optional<Slice>& slice) {
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
  if (!result) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min<size_t>(result.offset, text.size()));
    ThrowUsageError("{}:{}: not XML: {}", file, 1 + std::count(text.begin(), end, '\n'), result.description());
  }
  return WorldReader(file, slice).Read(document);
}

}  // namespace cairn
