#include "deploy/launcher/eval.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "actors/controllers/policy_controller.h"
#include "actors/controllers/pure_pursuit.h"
#include "actors/evaluation.h"
#include "common/config/load.h"
#include "common/core/check.h"
#include "common/core/files.h"
#include "common/nn/policy.h"
#include "common/rl/summary.h"
#include "deploy/launcher/local_tables.h"
#include "deploy/launcher/planned_world.h"
#include "deploy/launcher/run_directory.h"
#include "deploy/launcher/value_maps.h"
#include "planner/page/page.h"
#include "planner/picture.h"

namespace cairn::deploy {
namespace {

constexpr int kMaxBatch = 32;

// A controller, what it is called, and what it stands on.
struct Driver {
  std::string name;
  int64_t policy_version = 0;
  std::unique_ptr<Policy> policy;
  std::unique_ptr<actors::Controller> controller;
};

std::string ChoosePolicy(const RunDirectory& run, const std::string& wanted) {
  const auto exists = [&](const std::string& which) { return std::filesystem::exists(run.policy_file(which)); };
  if (!wanted.empty()) {
    if (!exists(wanted)) ThrowUsageError("--policy {}: there is no {}", wanted, run.policy_file(wanted));
    return wanted;
  }
  for (const char* which : {"best", "last"}) {
    if (exists(which)) return which;
  }
  ThrowUsageError("run directory {}: no policy in checkpoints/; has the run ended?", run.path());
}

Driver MakePolicyDriver(const RunDirectory& run, const LoadedExperiment& loaded, const std::string& wanted) {
  const std::string which = ChoosePolicy(run, wanted);
  const PolicyFile file = LoadPolicy(run.policy_file(which));
  const int size = ObservationSize(loaded.experiment);
  if (file.experiment_hash != loaded.hash || file.shape.observation_size != size) {
    ThrowError("{}: trained with another experiment ({:016x}, {} observations) than the directory's ({:016x}, {})",
               run.policy_file(which), file.experiment_hash, file.shape.observation_size, loaded.hash, size);
  }
  Driver driver;
  driver.name = fmt::format("policy {} ({} env steps, {})", which, file.env_steps, file.shape.ToString());
  driver.policy_version = file.version;
  driver.policy = std::make_unique<Policy>(file.shape, kMaxBatch);
  driver.policy->SetParameters(file.parameters);
  driver.controller = std::make_unique<actors::PolicyController>(*driver.policy, kMaxBatch);
  return driver;
}

// The referee keeps to a roadmap of its own, with room for its whole footprint.
Driver MakePurePursuitDriver(Experiment experiment) {
  experiment.planner = actors::PurePursuit::Planner(experiment);
  auto scene = std::make_shared<actors::Scene>(experiment);
  scene->SetTable(PlanWorld(experiment, experiment.planner).MakeLookup());
  Driver driver;
  driver.name = fmt::format("pure pursuit (roadmap with {:.3f} m to walls)", experiment.planner.radius);
  driver.controller = std::make_unique<actors::PurePursuit>(std::move(scene), MakeLocalTables(experiment));
  return driver;
}

Driver MakeDriver(const EvalOptions& options, const RunDirectory& run, const LoadedExperiment& loaded,
                  const Experiment& changed) {
  if (options.controller == "pure_pursuit") return MakePurePursuitDriver(changed);
  return MakePolicyDriver(run, loaded, options.policy);
}

// What the test starts are in.
std::string TestedWorlds(const Experiment& experiment) {
  const WorldConfig& world = experiment.world;
  if (experiment.goals == Goals::kWorld) return fmt::format("of world seed {}", world.seed);
  const bool unseen = world.unseen_worlds > 0;
  const uint64_t first = world.seed + static_cast<uint64_t>(unseen ? world.training_worlds : 0);
  const auto count = static_cast<uint64_t>(unseen ? world.unseen_worlds : world.training_worlds);
  return fmt::format("of world seeds {} to {}, each with a goal of its own", first, first + count - 1);
}

// The run's experiment with what was typed after --set and --seed.
Experiment ChangedExperiment(const EvalOptions& options, const RunDirectory& run, const LoadedExperiment& own) {
  Experiment changed = LoadExperiment(run.experiment_file(), options.overrides).experiment;
  if (options.seed) changed.seed = *options.seed;
  const int size = ObservationSize(changed), own_size = ObservationSize(own.experiment);
  if (size != own_size || changed.vehicle.action_size() != own.experiment.vehicle.action_size()) {
    ThrowUsageError("--set {}: the policy takes {} observations, and this makes {}", fmt::join(options.overrides, " "),
                    own_size, size);
  }
  return changed;
}

void CheckPictures(const EvalOptions& options, const Experiment& experiment) {
  if (experiment.goals == Goals::kWorld) return;
  for (const std::string& file : {options.svg, options.html, options.q_map, options.score_map}) {
    if (!file.empty()) ThrowUsageError("{}: pictures show one goal, and {} has goals = ANY", file, experiment.name);
  }
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
}

void PrintJson(const EvaluationSummary& summary, const EvalOptions& options, const Experiment& experiment) {
  nlohmann::ordered_json json;
  json["controller"] = options.controller;
  json["world_seed"] = experiment.world.seed;
  json["seed"] = experiment.seed;
  json["trials"] = summary.trials;
  json["successes"] = summary.successes;
  json["success_rate"] = summary.success_rate;
  json["success_interval"] = {summary.success_interval.low, summary.success_interval.high};
  json["collisions"] = summary.collisions;
  json["timeouts"] = summary.timeouts;
  json["diverged"] = summary.diverged;
  json["time_to_goal"] = summary.mean_time_to_goal;
  json["path_length"] = summary.mean_path_length;
  json["spl"] = summary.spl;
  json["min_clearance"] = summary.min_clearance;
  json["mean_clearance"] = summary.mean_clearance;
  json["jerk"] = summary.mean_jerk;
  json["return"] = summary.mean_return;
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
  const LoadedExperiment loaded = LoadExperiment(run.experiment_file());
  const Experiment experiment = ChangedExperiment(options, run, loaded);
  CheckSvg(options.svg, experiment);
  CheckPictures(options, experiment);
  const Driver driver = MakeDriver(options, run, loaded, experiment);
  PlannedWorld planned = PlanWorld(experiment, experiment.planner);
  auto scene = std::make_shared<actors::Scene>(experiment);
  scene->SetTable(planned.MakeLookup());
  const std::shared_ptr<const actors::Scene> met = actors::Scene::ForEvaluation(scene);
  planned.world = met->world();  // pictures show also what the planner was not told of

  const int trials = options.trials > 0 ? options.trials : experiment.evaluation.test_starts;
  actors::EvaluationOptions evaluation;
  evaluation.policy_version = driver.policy_version;
  evaluation.evaluation = actors::EvaluationOptions::KeyOf(driver.policy_version);
  evaluation.max_batch = kMaxBatch;
  evaluation.keep_marks = true;
  std::vector<actors::Trajectory> trajectories;
  const std::vector<EpisodeResult> results =
      actors::RunEpisodes(MakeLocalCourse(scene), StartSet::kTest, actors::AllStarts(trials), *driver.controller,
                          evaluation, options.svg.empty() && options.html.empty() ? nullptr : &trajectories);
  const EvaluationSummary summary = Summarise(results);
  const std::string title = experiment.name + ": " + driver.name, subtitle = ToString(summary);
  if (!options.svg.empty()) {
    WritePicture(planned, title, subtitle, ToPicture(trajectories, results), options.svg);
  }
  if (!options.html.empty()) {
    WritePage(planned, experiment, title, subtitle, ToPicture(trajectories, results), options.html);
  }
  if (!options.q_map.empty()) WriteQMap(run, *met, options.policy, options.height, options.q_map);
  if (!options.score_map.empty()) {
    WriteScoreMap(met, *driver.controller, evaluation, driver.name, options.height, options.score_map);
  }
  options.json ? PrintJson(summary, options, experiment) : PrintText(summary, driver.name, experiment);
  return 0;
}

}  // namespace cairn::deploy
