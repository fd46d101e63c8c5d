#include "common/config/roadmap_path.h"

#include <filesystem>

#include "common/config/load.h"
#include "common/core/check.h"
#include "common/core/files.h"
#include "common/core/hash.h"

namespace cairn::config {
namespace {

namespace fs = std::filesystem;

std::string HashOfFile(const Draft& draft, const std::string& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    ThrowUsageError("{}: planner.roadmap: {}: no such file", draft.Origin("planner.roadmap"), file);
  }
  const std::string bytes = ReadFile(file);
  return fmt::format("{:016x}", ContentHash(bytes.data(), bytes.size()));
}

}  // namespace

std::string FindRoadmap(const std::string& directory, Draft* draft) {
  proto::Planner* planner = draft->message.mutable_planner();
  if (planner->roadmap().empty()) {
    if (!planner->has_roadmap_hash()) return "";
    ThrowUsageError("{}: planner.roadmap_hash is read only with planner.roadmap",
                    draft->Origin("planner.roadmap_hash"));
  }
  const bool typed = draft->Origin("planner.roadmap").substr(0, 2) == "--";
  const std::string file = typed ? planner->roadmap() : (fs::path(directory) / planner->roadmap()).string();
  const std::string hash = HashOfFile(*draft, file);
  if (planner->has_roadmap_hash() && planner->roadmap_hash() != hash) {
    ThrowUsageError(
        "{}: planner.roadmap_hash = \"{}\": {} has changed, it now has {}; put it back, or leave "
        "roadmap_hash out and begin a new run",
        draft->Origin("planner.roadmap_hash"), planner->roadmap_hash(), file, hash);
  }
  planner->set_roadmap_hash(hash);
  planner->set_roadmap((fs::path(kRoadmapFolder) / fs::path(file).filename()).string());
  return file;
}

}  // namespace cairn::config
