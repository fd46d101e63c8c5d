#include "common/config/map.h"

#include <filesystem>

#include "common/config/load.h"
#include "common/core/check.h"

namespace cairn::config {
namespace {

namespace fs = std::filesystem;

// Fields that say something about a map only.
void CheckNoMap(const Draft& draft) {
  const proto::World& world = draft.message.world();
  const auto check = [&](const char* path, bool present) {
    if (present) ThrowUsageError("{}: {} is read only with world.kind = MAP", draft.Origin(path), path);
  };
  check("world.map", world.has_map());
  check("world.map_hash", world.has_map_hash());
  check("world.unknown_is_free", world.has_unknown_is_free());
  check("world.map_resolution", world.has_map_resolution());
  check("world.slice_min", world.has_slice_min());
  check("world.slice_max", world.has_slice_max());
}

std::optional<Slice> SliceOf(const Draft& draft) {
  const proto::World& world = draft.message.world();
  if (!world.has_slice_min() && !world.has_slice_max()) return std::nullopt;
  if (world.has_slice_min() && world.has_slice_max() && world.slice_min() < world.slice_max()) {
    return Slice{world.slice_min(), world.slice_max()};
  }
  const char* typed = world.has_slice_min() ? "world.slice_min" : "world.slice_max";
  ThrowUsageError("{}: world.slice_min and world.slice_max go together, the first below the second",
                  draft.Origin(typed));
}

std::optional<Box> WindowOf(const Draft& draft) {
  if (!draft.message.world().has_bounds()) return std::nullopt;
  const proto::Box& bounds = draft.message.world().bounds();
  Box window;
  window.min = {bounds.min().x(), bounds.min().y(), bounds.min().z()};
  window.max = {bounds.max().x(), bounds.max().y(), bounds.max().z()};
  if (!(window.min.x() < window.max.x() && window.min.y() < window.max.y() && window.min.z() <= window.max.z())) {
    ThrowUsageError("{}: world.bounds is empty: min must be below max, and in z not above it",
                    draft.Origin("world.bounds"));
  }
  return window;
}

MapOptions OptionsOf(const Draft& draft) {
  const proto::World& world = draft.message.world();
  MapOptions options;
  options.unknown_is_free = world.unknown_is_free();
  if (world.has_map_resolution()) options.cell_size = world.map_resolution();
  options.slice = SliceOf(draft);
  options.window = WindowOf(draft);
  return options;
}

void CheckHash(const Draft& draft, const std::string& file, const std::string& hash) {
  const proto::World& world = draft.message.world();
  if (!world.has_map_hash() || world.map_hash() == hash) return;
  ThrowUsageError(
      "{}: world.map_hash = \"{}\": {} has changed, or how it is read: it now has {}; put the map back, or leave "
      "map_hash out and begin a new run",
      draft.Origin("world.map_hash"), world.map_hash(), file, hash);
}

}  // namespace

ReadMapResult ReadMap(const std::string& directory, Draft* draft) {
  proto::World* world = draft->message.mutable_world();
  if (world->kind() != proto::World::MAP) {
    CheckNoMap(*draft);
    return {};
  }
  if (world->map().empty()) {
    ThrowUsageError("world.map is missing: world.kind = MAP ({}) needs it", draft->Origin("world.kind"));
  }
  ReadMapResult result;
  const bool typed = draft->Origin("world.map").substr(0, 2) == "--";
  result.file = typed ? world->map() : (fs::path(directory) / world->map()).string();
  result.map = std::make_shared<ImportedMap>(ImportMap(result.file, OptionsOf(*draft)));
  const std::string hash = fmt::format("{:016x}", result.map->hash);
  CheckHash(*draft, result.file, hash);
  world->set_map_hash(hash);
  world->set_map((fs::path(kMapFolder) / fs::path(result.file).filename()).string());
  return result;
}

}  // namespace cairn::config
