#include "deploy/launcher/eval.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "actors/evaluation.h"
#include "common/config/load.h"
#include "common/core/check.h"
#include "common/core/files.h"
#include "common/rl/summary.h"
#include "deploy/launcher/planned_world.h"
#include "deploy/launcher/run_directory.h"
#include "deploy/launcher/stress_page.h"
#include "deploy/launcher/summary_json.h"
#include "deploy/launcher/trials.h"
#include "deploy/launcher/value_maps.h"
#include "planner/page/page.h"
#include "planner/picture.h"

namespace cairn::deploy {
namespace {

// What the test starts are in.
std::string TestedWorlds(const Experiment& experiment) {
  const WorldConfig& world = experiment.world;
  if (experiment.goals == Goals::kWorld) return fmt::format("of world seed {}", world.seed);
  const bool unseen = world.unseen_worlds > 0;
  const uint64_t first = world.seed + static_cast<uint64_t>(unseen ? world.training_worlds : 0);
  const auto count = static_cast<uint64_t>(unseen ? world.unseen_worlds : world.training_worlds);
  return fmt::format("of world seeds {} to {}, each with a goal of its own", first, first + count - 1);
}

void CheckPictures(const EvalOptions& options, const Experiment& experiment) {
  if (experiment.goals == Goals::kWorld) return;
  for (const std::string& file : {options.svg, options.html, options.q_map, options.score_map}) {
    if (!file.empty()) ThrowUsageError("{}: pictures show one goal, and {} has goals = ANY", file, experiment.name);
  }
}

// One picture of success is all that many conditions make.
void CheckConditions(const EvalOptions& options) {
  const char* other = !options.html.empty()        ? "--html"
                      : !options.q_map.empty()     ? "--q-map"
                      : !options.score_map.empty() ? "--score-map"
                      : options.height             ? "--height"
                                                   : nullptr;
  if (other != nullptr) ThrowUsageError("{}: it does not go with --conditions", other);
}

void PrintText(const EvaluationSummary& summary, const std::string& driver, const Experiment& experiment) {
  fmt::print("controller     {}\n", driver);
  fmt::print("test starts    {} {}, disturbance seed {}\n", summary.trials, TestedWorlds(experiment), experiment.seed);
  fmt::print("success        {} / {} = {:.4f}, 95 % within {:.4f} to {:.4f} (Wilson)\n", summary.successes,
             summary.trials, summary.success_rate, summary.success_interval.low, summary.success_interval.high);
  fmt::print("collisions     {}\ntime-outs      {}\ndiverged       {}\n", summary.collisions, summary.timeouts,
             summary.diverged);
  fmt::print("time to goal   {:.2f} s, mean of successes\n", summary.mean_time_to_goal);
  fmt::print("path length    {:.2f} m, mean of successes\n", summary.mean_path_length);
  fmt::print("SPL            {:.4f}\n", summary.spl);
  fmt::print("clearance      {:.4f} m smallest, {:.4f} m mean of episodes' smallest\n", summary.min_clearance,
             summary.mean_clearance);
  fmt::print("jerk           {:.2f} m/s^3\n", summary.mean_jerk);
  fmt::print("return         {:.2f}\n", summary.mean_return);
  if (experiment.safety.filter == SafetyConfig::Filter::kOff) return;
  fmt::print("safety filter  changed commands in {} of {} steps\n", summary.filtered_steps, summary.steps);
}

void PrintJson(const EvaluationSummary& summary, const std::string& controller, const Experiment& experiment) {
  nlohmann::ordered_json json;
  json["controller"] = controller;
  json["world_seed"] = experiment.world.seed;
  json["seed"] = experiment.seed;
  json.update(ToJson(summary));
  fmt::print("{}\n", json.dump(2));
}

planner::Trajectory ToPicture(const actors::Trajectory& trajectory, Outcome outcome) {
  planner::Trajectory drawn;
  drawn.outcome = outcome;
  for (const auto& [x, y, z] : trajectory) drawn.points.emplace_back(x, y, z);
  return drawn;
}

std::vector<planner::Trajectory> ToPicture(const std::vector<actors::Trajectory>& trajectories,
                                           const std::vector<EpisodeResult>& results) {
  std::vector<planner::Trajectory> drawn;
  for (size_t i = 0; i < results.size(); ++i) drawn.push_back(ToPicture(trajectories[i], results[i].outcome));
  return drawn;
}

void WritePicture(const PlannedWorld& planned, const std::string& title, const std::string& subtitle,
                  const std::vector<planner::Trajectory>& drawn, const std::string& file) {
  planner::PictureOptions picture;
  picture.title = title;
  picture.subtitle = subtitle;
  picture.longest_edge = 2 * planned.r_ball;
  picture.optimal_path = false;
  WriteFileAtomically(file, planner::DrawScene(planned.world, &planned.built.roadmap, &planned.table, drawn, picture));
}

void WritePage(const PlannedWorld& planned, const Experiment& experiment, const std::string& title,
               const std::string& subtitle, const std::vector<planner::Trajectory>& drawn, const std::string& file) {
  planner::PageOptions page;
  page.title = title;
  page.subtitle = subtitle;
  page.longest_edge = 2 * planned.r_ball;
  page.vehicle_radius = experiment.vehicle.inscribed_radius();
  page.step = experiment.environment.control_period;
  page.optimal_path = false;
  WriteFileAtomically(file, planner::MakePage(planned.world, &planned.built.roadmap, &planned.table, drawn, page));
}

}  // namespace

int Eval(const EvalOptions& options) {
  const RunDirectory run = RunDirectory::Open(options.run_dir);
  const LoadedExperiment own = LoadExperiment(run.experiment_file());
  if (!options.conditions.empty()) {
    CheckConditions(options);
    return DriveConditions(options, run, own);
  }
  const Experiment experiment = ChangedExperiment(run, own, options.overrides, options.seed);
  CheckSvg(options.svg, experiment);
  CheckPictures(options, experiment);
  const Driver driver = MakeDriver(options.controller, run, own, options.policy, experiment);
  PlannedWorld planned = PlanWorld(experiment, experiment.planner);
  const std::shared_ptr<const actors::Scene> scene = MakePlannedScene(experiment, planned);
  const std::shared_ptr<const actors::Scene> met = actors::Scene::ForEvaluation(scene);
  planned.world = met->world();  // pictures show also what the planner was not told of

  const int trials = options.trials > 0 ? options.trials : experiment.evaluation.test_starts;
  std::vector<actors::Trajectory> trajectories;
  const bool draws = !options.svg.empty() || !options.html.empty();
  const std::vector<EpisodeResult> results = RunTrials(scene, driver, trials, draws ? &trajectories : nullptr);
  const EvaluationSummary summary = Summarise(results);
  const std::string controller = options.controller.empty() ? "policy" : options.controller;
  options.json ? PrintJson(summary, controller, experiment) : PrintText(summary, driver.name, experiment);
  std::fflush(stdout);  // whatever becomes of the pictures
  const std::string title = experiment.name + ": " + driver.name, subtitle = ToString(summary);
  if (!options.svg.empty()) {
    WritePicture(planned, title, subtitle, ToPicture(trajectories, results), options.svg);
  }
  if (!options.html.empty()) {
    WritePage(planned, experiment, title, subtitle, ToPicture(trajectories, results), options.html);
  }
  if (!options.q_map.empty()) WriteQMap(run, *met, options.policy, options.height, options.q_map);
  if (!options.score_map.empty()) {
    actors::EvaluationOptions evaluation;
    evaluation.policy_version = driver.policy_version;
    evaluation.evaluation = actors::EvaluationOptions::KeyOf(driver.policy_version);
    evaluation.max_batch = kMaxBatch;
    WriteScoreMap(met, *driver.make(), evaluation, driver.name, options.height, options.score_map);
  }
  return 0;
}

}  // namespace cairn::deploy
