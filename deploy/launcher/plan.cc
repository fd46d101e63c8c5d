#include "deploy/launcher/plan.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "common/config/load.h"
#include "common/world/distance_field.h"
#include "planner/planner.h"

namespace cairn::deploy {
namespace {

void PrintJson(const planner::BuiltRoadmap& built, const CostTable& table) {
  nlohmann::ordered_json json;
  json["vertices"] = built.info.vertices;
  json["edges"] = built.info.edges;
  json["samples"] = built.info.samples;
  json["coverage"] = built.info.coverage;
  json["components"] = built.info.components;
  json["max_cost"] = table.max_cost();
  json["roadmap_hash"] = fmt::format("{:016x}", built.roadmap.Hash());
  json["table_hash"] = fmt::format("{:016x}", table.Hash());
  json["build_s"] = built.info.build_s;
  fmt::print("{}\n", json.dump(2));
}

void PrintText(const World& world, const planner::BuiltRoadmap& built, const CostTable& table) {
  const planner::BuildInfo& info = built.info;
  fmt::print("world         {:.2f} x {:.2f} m, {} obstacles\n", world.bounds.size().x(), world.bounds.size().y(),
             world.boxes.size() + world.cylinders.size());
  fmt::print("vertices      {}\nedges         {}\ncomponents    {}\n", info.vertices, info.edges, info.components);
  fmt::print("coverage      {:.4f} of free space within r_ball of a vertex\n", info.coverage);
  fmt::print("longest cost  {:.3f} m\n", table.max_cost());
  fmt::print("build time    {:.3f} s, {} samples\n", info.build_s, info.samples);
}

}  // namespace

int Plan(const PlanOptions& options) {
  const Experiment experiment = LoadExperiment(options.file, options.overrides).experiment;
  const World world = MakeWorld(experiment.world);
  const DistanceField field(world, experiment.world.field_resolution);
  const planner::BuiltRoadmap built =
      planner::BuildRoadmap(world, field, experiment.planner, experiment.vehicle.inscribed_radius());
  const CostTable table = planner::ComputeCostTable(built.roadmap, world, world.goal);
  if (options.json) {
    PrintJson(built, table);
  } else {
    PrintText(world, built, table);
  }
  return 0;
}

}  // namespace cairn::deploy
