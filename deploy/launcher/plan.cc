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

void PrintJson(const PlannedWorld& planned, double path_length) {
  const planner::BuildInfo& info = planned.built.info;
  nlohmann::ordered_json json;
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
  fmt::print("world         {:.2f} x {:.2f} m, {} obstacles\n", world.bounds.size().x(), world.bounds.size().y(),
             world.boxes.size() + world.cylinders.size());
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
  WriteFileAtomically(file, planner::DrawScene(planned.world, &planned.built.roadmap, &planned.table, {}, picture));
}

void WritePage(const PlannedWorld& planned, const std::string& name, const std::string& file) {
  planner::PageOptions page;
  page.title = name;
  page.subtitle = Subtitle(planned.built.info);
  WriteFileAtomically(file, planner::MakePage(planned.world, &planned.built.roadmap, &planned.table, {}, page));
}

}  // namespace

int Plan(const PlanOptions& options) {
  const Experiment experiment = LoadExperiment(options.file, options.overrides).experiment;
  CheckSvg(options.svg, experiment);
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
