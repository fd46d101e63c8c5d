#include "deploy/launcher/plan.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "common/config/load.h"
#include "common/core/check.h"
#include "common/core/files.h"
#include "deploy/launcher/planned_world.h"
#include "deploy/launcher/scenario_check.h"
#include "planner/page/page.h"
#include "planner/path.h"
#include "planner/picture.h"
#include "planner/value_map.h"

namespace cairn::deploy {
namespace {

std::string ToString(const Box& box, int dimension) {
  std::string text;
  for (int k = 0; k < dimension; ++k) {
    text += fmt::format("{}{} {:.2f} to {:.2f}", k == 0 ? "" : ", ", "xyz"[k], box.min[k], box.max[k]);
  }
  return text + " m";
}

void AddWorld(const World& world, nlohmann::ordered_json* json) {
  const auto list = [&](const Vector3d& p) { return std::vector<double>(p.data(), p.data() + world.dimension); };
  (*json)["world"] = {{"min", list(world.bounds.min)},
                      {"max", list(world.bounds.max)},
                      {"boxes", world.boxes.size()},
                      {"cylinders", world.cylinders.size()},
                      {"doors", world.doors.size()}};
}

void PrintWorld(const World& world) {
  fmt::print("world         {}, {} obstacles\n", ToString(world.bounds, world.dimension),
             world.boxes.size() + world.cylinders.size());
  if (!world.doors.empty()) fmt::print("doors         {}, numbered in the pictures\n", world.doors.size());
}

void PrintJson(const PlannedWorld& planned, double path_length) {
  const planner::BuildInfo& info = planned.built.info;
  nlohmann::ordered_json json;
  AddWorld(planned.world, &json);
  json["goal_reached_from"] = planned.free_share;
  json["kind"] = planner::NameOf(info.kind);
  json["vertices"] = info.vertices;
  json["bends"] = info.bends;
  json["edges"] = info.edges;
  json["samples"] = info.samples;
  json["coverage"] = info.coverage;
  json["components"] = info.components;
  json["max_cost"] = planned.table.max_cost();
  json["path_length"] = path_length;
  json["roadmap_hash"] = fmt::format("{:016x}", planned.built.roadmap.Hash());
  json["table_hash"] = fmt::format("{:016x}", planned.table.Hash());
  json["build_s"] = info.build_s;
  fmt::print("{}\n", json.dump(2));
}

void PrintText(const PlannedWorld& planned, double path_length) {
  const planner::BuildInfo& info = planned.built.info;
  const World& world = planned.world;
  PrintWorld(world);
  fmt::print("goal          {}, reached from {:.2f} % of free space\n", ToString(world.goal, world.dimension),
             100 * planned.free_share);
  fmt::print("planner       {}\n", planner::NameOf(info.kind));
  fmt::print("vertices      {}, {} of them bends\nedges         {}\ncomponents    {}\n", info.vertices, info.bends,
             info.edges, info.components);
  fmt::print("coverage      {:.4f} of free space within r_ball of a vertex\n", info.coverage);
  fmt::print("optimal path  {:.3f} m from the start region\n", path_length);
  fmt::print("longest cost  {:.3f} m\n", planned.table.max_cost());
  fmt::print("build time    {:.3f} s, {} samples\n", info.build_s, info.samples);
}

std::string Subtitle(const planner::BuildInfo& info) {
  return fmt::format("{} vertices, {} bends, {} edges, coverage {:.4f}", info.vertices - info.bends, info.bends,
                     info.edges, info.coverage);
}

// More vertices than this are no lines to look at but a surface.
constexpr int kMaxDrawnVertices = 100000;
constexpr int kCellsAcross = 760;  // one a pixel

void WriteCostPicture(const PlannedWorld& planned, planner::PictureOptions picture, const std::string& file) {
  const planner::ValueMap costs = planner::MapCosts(planned.world, planned.built.roadmap, planned.table, kCellsAcross);
  picture.values = &costs;
  const planner::Path path = planner::OptimalPath(planned.world, planned.built.roadmap, planned.table);
  WriteFileAtomically(file,
                      planner::DrawScene(planned.world, nullptr, nullptr, {{path.points, Outcome::kGoal}}, picture));
}

void WritePicture(const PlannedWorld& planned, const std::string& name, const std::string& file) {
  planner::PictureOptions picture;
  picture.title = name;
  picture.subtitle = Subtitle(planned.built.info);
  if (planned.built.info.vertices > kMaxDrawnVertices) return WriteCostPicture(planned, picture, file);
  picture.r_ball = planned.r_ball;
  picture.door_numbers = true;
  picture.longest_edge = 2 * planned.r_ball;
  WriteFileAtomically(file, planner::DrawScene(planned.world, &planned.built.roadmap, &planned.table, {}, picture));
}

constexpr const char* kNoGoal = "no goal yet: give one as --goal X,Y";

// A map without a goal: its picture is what one reads the goal from.
int PlanMapOnly(const PlanOptions& options, const Experiment& experiment) {
  const World world = MakeWorldWithoutGoal(experiment.world);
  if (!options.svg.empty()) {
    planner::PictureOptions picture;
    picture.title = experiment.name;
    picture.subtitle = kNoGoal;
    picture.regions = false;
    WriteFileAtomically(options.svg, planner::DrawScene(world, nullptr, nullptr, {}, picture));
  }
  if (!options.html.empty()) {
    planner::PageOptions page;
    page.title = experiment.name;
    page.subtitle = kNoGoal;
    page.regions = false;
    WriteFileAtomically(options.html, planner::MakePage(world, nullptr, nullptr, {}, page));
  }
  if (options.json) {
    nlohmann::ordered_json json;
    AddWorld(world, &json);
    fmt::print("{}\n", json.dump(2));
  } else {
    PrintWorld(world);
    fmt::print("no goal yet   give one as --goal X,Y; --svg FILE draws the map with a grid to read it from\n");
  }
  return 0;
}

bool HasGoal(const WorldConfig& world) {
  return world.kind != WorldConfig::Kind::kMap || world.goal_point || world.goal != BoxConfig{};
}

void WritePage(const PlannedWorld& planned, const std::string& name, const std::string& file) {
  planner::PageOptions page;
  page.title = name;
  page.subtitle = Subtitle(planned.built.info);
  page.door_numbers = true;
  page.longest_edge = 2 * planned.r_ball;
  const bool drawn = planned.built.info.vertices <= kMaxDrawnVertices;
  if (!drawn) page.subtitle += ": too many to draw";
  WriteFileAtomically(file, planner::MakePage(planned.world, drawn ? &planned.built.roadmap : nullptr,
                                              drawn ? &planned.table : nullptr, {}, page));
}

void CheckAlone(const PlanOptions& options) {
  const char* other = !options.svg.empty()    ? "--svg"
                      : !options.html.empty() ? "--html"
                      : !options.save.empty() ? "--save"
                                              : nullptr;
  if (other != nullptr) ThrowUsageError("--scen {}: {} does not go with it; it builds no roadmap", options.scen, other);
}

}  // namespace

int Plan(const PlanOptions& options) {
  const Experiment experiment = LoadExperiment(options.file, options.overrides, options.place).experiment;
  if (!options.scen.empty()) {
    CheckAlone(options);
    return CheckScenario(options.scen, experiment.world, options.json);
  }
  CheckSvg(options.svg, experiment);
  if (!HasGoal(experiment.world)) {
    if (!options.save.empty()) ThrowUsageError("--save {}: a roadmap needs a goal, --goal X,Y", options.save);
    return PlanMapOnly(options, experiment);
  }
  const PlannedWorld planned = PlanWorld(experiment, experiment.planner);
  const double path_length = planner::OptimalPath(planned.world, planned.built.roadmap, planned.table).length;
  if (!options.svg.empty()) WritePicture(planned, experiment.name, options.svg);
  if (!options.html.empty()) WritePage(planned, experiment.name, options.html);
  if (!options.save.empty()) {
    WriteFileAtomically(options.save, planner::SaveRoadmap(planned.world, experiment.planner, planned.built));
  }
  if (options.json) {
    PrintJson(planned, path_length);
  } else {
    PrintText(planned, path_length);
  }
  return 0;
}

}  // namespace cairn::deploy
