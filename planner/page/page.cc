#include "planner/page/page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "common/core/check.h"
#include "planner/color_map.h"
#include "planner/outcome_style.h"
#include "planner/page/files.h"
#include "planner/path.h"
#include "planner/shown_edges.h"

namespace cairn::planner {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kColors = 48;
constexpr double kUnit = 1e-4;         // coordinates and costs are rounded to it [m]
constexpr double kWallHeight = 0.035;  // of a plane world's walls, in longer sides of its bounds

double Round(double value) {
  CAIRN_CHECK(std::isfinite(value));
  return std::round(value / kUnit) / std::round(1 / kUnit) + 0.0;
}

void Append(const Vector3d& p, Json* out) {
  for (int k = 0; k < 3; ++k) out->push_back(Round(p[k]));
}

Json ToJson(const std::vector<Vector3d>& points) {
  Json out = Json::array();
  for (const Vector3d& p : points) {
    if (p.allFinite()) Append(p, &out);
  }
  return out;
}

Json ToJson(const Box& box) { return ToJson(std::vector<Vector3d>{box.min, box.max}); }

// A plane world becomes one in space, with walls of a height that does not hide what is behind them.
World Raise(World world) {
  if (world.dimension == 3) return world;
  const double height = kWallHeight * std::max(world.bounds.size().x(), world.bounds.size().y());
  const auto raise = [height](Box* box) {
    box->min.z() = 0;
    box->max.z() = height;
  };
  for (Box* box : {&world.bounds, &world.start, &world.goal}) raise(box);
  for (Box& box : world.boxes) raise(&box);
  for (Cylinder& cylinder : world.cylinders) {
    cylinder.base.z() = 0;
    cylinder.height = height;
  }
  return world;
}

// Where the numbers of doors stand: in space in the doors' middles, in a plane world on top of its walls.
Json DoorsJson(const World& world, const World& raised) {
  Json out = Json::array();
  for (const Box& door : world.doors) {
    Vector3d at = door.center();
    if (world.dimension == 2) at.z() = raised.bounds.max.z();
    Append(at, &out);
  }
  return out;
}

Json WorldJson(const World& world, const PageOptions& options) {
  const World raised = Raise(world);
  Json boxes = Json::array(), cylinders = Json::array();
  for (const Box& box : raised.boxes) {
    Append(box.min, &boxes);
    Append(box.max, &boxes);
  }
  for (const Cylinder& cylinder : raised.cylinders) {
    Append(cylinder.base, &cylinders);
    cylinders.push_back(Round(cylinder.radius));
    cylinders.push_back(Round(cylinder.height));
  }
  Json out = {{"dimension", world.dimension},
              {"bounds", ToJson(raised.bounds)},
              {"boxes", std::move(boxes)},
              {"cylinders", std::move(cylinders)}};
  if (options.door_numbers && !world.doors.empty()) out["doors"] = DoorsJson(world, raised);
  if (!options.regions) return out;
  out["start"] = ToJson(raised.start);
  out["goal"] = ToJson(raised.goal);
  return out;
}

// Costs are -1 where the goal cannot be reached and left out without a table.
Json RoadmapJson(const Roadmap& roadmap, const CostTable* table, double longest_edge) {
  Json vertices = Json::array(), edges = Json::array(), costs = Json::array();
  for (int v = 0; v < roadmap.num_places(); ++v) {
    Append(roadmap.position(v), &vertices);
    if (table) costs.push_back(std::isfinite(table->cost[v]) ? Round(table->cost[v]) : -1);
  }
  ForEachShownEdge(roadmap, longest_edge, [&](int v, int u) {
    edges.push_back(v);
    edges.push_back(u);
  });
  Json out = {{"vertices", std::move(vertices)}, {"edges", std::move(edges)}};
  if (!table) return out;
  out["costs"] = std::move(costs);
  out["maxCost"] = std::max(Round(table->max_cost()), kUnit);
  out["colors"] = Json::array();
  for (int i = 0; i < kColors; ++i) out["colors"].push_back(CostColor(i / (kColors - 1.0)));
  return out;
}

Json TrajectoriesJson(const std::vector<Trajectory>& trajectories) {
  Json out = Json::array();
  for (const OutcomeStyle& style : kOutcomeStyles) {
    Json paths = Json::array();
    for (const Trajectory& trajectory : trajectories) {
      if (trajectory.outcome != style.outcome) continue;
      Json points = ToJson(trajectory.points);
      if (!points.empty()) paths.push_back(std::move(points));
    }
    if (paths.empty()) continue;
    out.push_back({{"name", OutcomeName(style.outcome)}, {"color", style.color}, {"paths", std::move(paths)}});
  }
  return out;
}

Json PathJson(const Path& path) { return {{"points", ToJson(path.points)}, {"length", Round(path.length)}}; }

// "<" would let a text end the element that holds the data.
std::string Dump(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      escaped += "\\u003c";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

// The template with each {{name}} replaced; what is put in is not searched.
std::string Fill(std::string_view page, const std::vector<std::pair<std::string_view, std::string_view>>& parts) {
  std::string filled;
  for (const auto& [name, text] : parts) {
    const size_t at = page.find(name);
    CAIRN_CHECK(at != std::string_view::npos, "page.html has no {} in its place", name);
    filled.append(page.substr(0, at)).append(text);
    page.remove_prefix(at + name.size());
  }
  return filled.append(page);
}

}  // namespace

std::string MakePage(const World& world, const Roadmap* roadmap, const CostTable* table,
                     const std::vector<Trajectory>& trajectories, const PageOptions& options) {
  if (roadmap && table && static_cast<int>(table->cost.size()) != roadmap->num_vertices()) {
    ThrowError("page: cost table of {} vertices, roadmap of {}", table->cost.size(), roadmap->num_vertices());
  }
  Json data = {{"title", options.title}, {"subtitle", options.subtitle}, {"world", WorldJson(world, options)}};
  if (roadmap) data["roadmap"] = RoadmapJson(*roadmap, table, options.longest_edge);
  if (roadmap && table && options.optimal_path) data["path"] = PathJson(OptimalPath(world, *roadmap, *table));
  data["trajectories"] = TrajectoriesJson(trajectories);
  data["vehicleRadius"] = Round(options.vehicle_radius);
  data["step"] = options.step;
  const std::string json = Dump(data);
  return Fill(kPageHtml,
              {{"{{data}}", json}, {"{{three}}", kThreeJs}, {"{{controls}}", kOrbitControlsJs}, {"{{page}}", kPageJs}});
}

}  // namespace cairn::planner
