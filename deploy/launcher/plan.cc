#include "deploy/launcher/plan.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "common/config/load.h"
#include "common/core/files.h"
#include "deploy/launcher/planned_world.h"
#include "planner/page/page.h"
#include "planner/path.h"
#include "planner/picture.h"

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
  json["vertices"] = info.vertices;
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
  fmt::print("vertices      {}\nedges         {}\ncomponents    {}\n", info.vertices, info.edges, info.components);
  fmt::print("coverage      {:.4f} of free space within r_ball of a vertex\n", info.coverage);
  fmt::print("optimal path  {:.3f} m from the start region\n", path_length);
  fmt::print("longest cost  {:.3f} m\n", planned.table.max_cost());
  fmt::print("build time    {:.3f} s, {} samples\n", info.build_s, info.samples);
}

std::string Subtitle(const planner::BuildInfo& info) {
  return fmt::format("{} vertices, {} edges, coverage {:.4f}", info.vertices, info.edges, info.coverage);
}

void WritePicture(const PlannedWorld& planned, const std::string& name, const std::string& file) {
  planner::PictureOptions picture;
  picture.title = name;
  picture.subtitle = Subtitle(planned.built.info);
  picture.r_ball = planned.r_ball;
  picture.door_numbers = true;
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
  WriteFileAtomically(file, planner::MakePage(planned.world, &planned.built.roadmap, &planned.table, {}, page));
}

}  // namespace

int Plan(const PlanOptions& options) {
  const Experiment experiment = LoadExperiment(options.file, options.overrides, options.place).experiment;
  CheckSvg(options.svg, experiment);
  if (!HasGoal(experiment.world)) return PlanMapOnly(options, experiment);
  const PlannedWorld planned = PlanWorld(experiment, experiment.planner);
  const double path_length = planner::OptimalPath(planned.world, planned.built.roadmap, planned.table).length;
  if (!options.svg.empty()) WritePicture(planned, experiment.name, options.svg);
  if (!options.html.empty()) WritePage(planned, experiment.name, options.html);
  if (options.json) {
    PrintJson(planned, path_length);
  } else {
    PrintText(planned, path_length);
  }
  return 0;
}

}  // namespace cairn::deploy
