#include "deploy/launcher/scenario_check.h"

#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "common/core/check.h"
#include "common/core/clock.h"
#include "common/core/files.h"
#include "common/world/import/import_map.h"
#include "common/world/import/moving_ai.h"
#include "common/world/import/moving_ai_scenario.h"
#include "planner/cell_search.h"

namespace cairn::deploy {
namespace {

namespace fs = std::filesystem;

// Lengths are published with about eight digits; one corner cut makes a way shorter by 0.59 cells.
constexpr double kTolerance = 1e-3;  // [cells]

struct Mismatch {
  ScenarioPath path;
  std::optional<double> shortest;  // none: no way
};

std::string Read(const std::string& file) {
  try {
    return ReadFile(file);
  } catch (const Error& unreadable) {
    ThrowUsageError("--scen: {}", unreadable.what());
  }
}

CellGrid ReadMap(const std::string& scen, const WorldConfig& world) {
  const std::string& file = world.map.file;
  if (world.kind != WorldConfig::Kind::kMap || fs::path(file).extension() != ".map") {
    ThrowUsageError("--scen {}: it goes with a Moving AI map, --map FILE.map", scen);
  }
  return ReadMovingAi(Read(file), file, 1, MapOptions{}.max_cells);
}

void CheckSameMap(const std::string& scen, const Scenario& scenario, const std::string& map, const CellGrid& grid) {
  const std::string named = fs::path(scenario.map).filename().string(), given = fs::path(map).filename().string();
  if (named == given && scenario.width == grid.size.x() && scenario.height == grid.size.y()) return;
  ThrowUsageError("--scen {}: it is of {}, {} x {} cells; the map given is {}, {} x {} cells", scen, named,
                  scenario.width, scenario.height, given, grid.size.x(), grid.size.y());
}

std::vector<Mismatch> Compare(const Scenario& scenario, const CellGrid& grid) {
  planner::CellSearch search(grid, 8);
  // A scenario counts rows from the top, the grid from below.
  const auto cell = [&](const std::array<int, 2>& at) { return Eigen::Vector3i(at[0], grid.size.y() - 1 - at[1], 0); };
  std::vector<Mismatch> mismatches;
  for (const ScenarioPath& path : scenario.paths) {
    const std::optional<double> shortest = search.Length(cell(path.start), cell(path.goal));
    if (!shortest || std::abs(*shortest - path.length) > kTolerance) mismatches.push_back({path, shortest});
  }
  return mismatches;
}

void PrintText(const std::string& file, const Scenario& scenario, const std::vector<Mismatch>& mismatches,
               double seconds) {
  for (const auto& [path, shortest] : mismatches) {
    fmt::print("{}:{}: ({}, {}) to ({}, {}): published {:.8f}, ", file, path.line, path.start[0], path.start[1],
               path.goal[0], path.goal[1], path.length);
    fmt::print("{}\n", shortest ? fmt::format("shortest {:.8f}", *shortest) : "but there is no way");
  }
  if (!mismatches.empty() && !scenario.ends_in_line) fmt::print("{}: its last line has no end: torn?\n", file);
  fmt::print("{}: {} paths on {}, {} agree, {} differ, {:.3f} s\n", file, scenario.paths.size(), scenario.map,
             scenario.paths.size() - mismatches.size(), mismatches.size(), seconds);
}

void PrintJson(const std::string& file, const Scenario& scenario, const std::vector<Mismatch>& mismatches,
               double seconds) {
  nlohmann::ordered_json json;
  json["scenario"] = file;
  json["map"] = scenario.map;
  json["paths"] = scenario.paths.size();
  json["agree"] = scenario.paths.size() - mismatches.size();
  json["mismatches"] = nlohmann::ordered_json::array();
  for (const auto& [path, shortest] : mismatches) {
    nlohmann::ordered_json entry;
    entry["line"] = path.line;
    entry["start"] = path.start;
    entry["goal"] = path.goal;
    entry["published"] = path.length;
    entry["shortest"] = shortest ? nlohmann::ordered_json(*shortest) : nlohmann::ordered_json(nullptr);
    json["mismatches"].push_back(std::move(entry));
  }
  json["seconds"] = seconds;
  fmt::print("{}\n", json.dump(2));
}

}  // namespace

int CheckScenario(const std::string& file, const WorldConfig& world, bool json) {
  const CellGrid grid = ReadMap(file, world);
  const Scenario scenario = ReadScenario(Read(file), file);
  CheckSameMap(file, scenario, world.map.file, grid);
  const TimePoint begin = Clock::now();
  const std::vector<Mismatch> mismatches = Compare(scenario, grid);
  (json ? PrintJson : PrintText)(file, scenario, mismatches, SecondsSince(begin));
  return mismatches.empty() ? 0 : 1;
}

}  // namespace cairn::deploy
