#include "deploy/launcher/stress_page.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "common/config/conditions.h"
#include "common/core/check.h"
#include "common/core/files.h"
#include "common/core/log.h"
#include "deploy/launcher/planned_world.h"
#include "deploy/launcher/stress_picture.h"
#include "deploy/launcher/summary_json.h"
#include "deploy/launcher/trials.h"

namespace cairn::deploy {
namespace {

void PrintConditions(const std::vector<StressResult>& results, const std::vector<std::string>& drivers) {
  for (const std::string& driver : drivers) fmt::print("{}\n", driver);
  fmt::print("{:<24} {:>9} {:<13} {:>8} {:>17} {:>10} {:>9} {:>8} {:>8} {:>9}\n", "knob", "value", "controller",
             "success", "95 % (Wilson)", "collisions", "time-outs", "time [s]", "jerk", "filtered");
  for (const StressResult& r : results) {
    const EvaluationSummary& s = r.summary;
    fmt::print("{:<24} {:>9.4g} {:<13} {:>8.4f}   {:.4f} – {:.4f} {:>10} {:>9} {:>8.2f} {:>8.2f} {:>9.4f}\n",
               r.knob->name, r.point->value, r.controller, s.success_rate, s.success_interval.low,
               s.success_interval.high, s.collisions, s.timeouts, s.mean_time_to_goal, s.mean_jerk,
               static_cast<double>(s.filtered_steps) / static_cast<double>(std::max<int64_t>(1, s.steps)));
  }
}

void PrintConditionsJson(const std::vector<StressResult>& results, const Experiment& experiment,
                         const std::vector<std::string>& drivers) {
  nlohmann::ordered_json json;
  json["experiment"] = experiment.name;
  json["world_seed"] = experiment.world.seed;
  json["drivers"] = drivers;
  json["results"] = nlohmann::ordered_json::array();
  for (const StressResult& r : results) {
    nlohmann::ordered_json row;
    row["knob"] = r.knob->name;
    row["unit"] = r.knob->unit;
    row["value"] = r.point->value;
    row["set"] = r.point->overrides;
    row["controller"] = r.controller;
    row.update(ToJson(r.summary));
    json["results"].push_back(row);
  }
  fmt::print("{}\n", json.dump(2));
}

// Every controller at every point of every knob.
class StressPage {
 public:
  StressPage(const EvalOptions& options, const RunDirectory& run, const LoadedExperiment& own)
      : options_(options),
        run_(run),
        own_(own),
        conditions_(LoadConditions(options.conditions, own.experiment.vehicle.circumscribed_radius())) {
    if (options.trials > 0) conditions_.trials = options.trials;
    controllers_ = {"policy", "pure_pursuit"};
    if (!options.controller.empty()) controllers_ = {options.controller};
  }

  int Run() {
    for (const Knob& knob : conditions_.knobs) {
      for (const ConditionPoint& point : knob.points) DriveAt(knob, point);
    }
    if (!options_.svg.empty()) {
      const std::string subtitle =
          fmt::format("success of {} test starts a point with 95 % intervals (Wilson){}{}", conditions_.trials,
                      options_.overrides.empty() ? "" : "; ", fmt::join(options_.overrides, ", "));
      WriteFileAtomically(options_.svg, DrawStress(own_.experiment.name, subtitle, results_));
    }
    options_.json ? PrintConditionsJson(results_, own_.experiment, names_) : PrintConditions(results_, names_);
    return 0;
  }

 private:
  using Summaries = std::vector<std::pair<std::string, EvaluationSummary>>;  // by controller

  void DriveAt(const Knob& knob, const ConditionPoint& point) {
    std::vector<std::string> overrides = conditions_.overrides;
    overrides.insert(overrides.end(), options_.overrides.begin(), options_.overrides.end());
    overrides.insert(overrides.end(), point.overrides.begin(), point.overrides.end());
    // Where a knob is at rest every page says the same.
    auto [known, is_new] = summaries_.try_emplace(fmt::format("{}", fmt::join(overrides, " ")));
    if (is_new) known->second = Drive(overrides);
    for (const auto& [controller, summary] : known->second) {
      results_.push_back({&knob, &point, controller, summary});
      log::Info("{} = {}: {}: {}", knob.name, point.value, controller, ToString(summary));
    }
  }

  Summaries Drive(const std::vector<std::string>& overrides) {
    const Experiment experiment = ChangedExperiment(run_, own_, overrides, options_.seed);
    Plan(experiment);
    const std::shared_ptr<const actors::Scene> scene = MakePlannedScene(experiment, *planned_);
    Summaries summaries;
    for (const auto& [controller, driver] : drivers_) {
      summaries.emplace_back(controller, Summarise(RunTrials(scene, driver, conditions_.trials)));
    }
    return summaries;
  }

  // Most knobs leave the world as it is, and with it the roadmaps.
  void Plan(const Experiment& experiment) {
    const bool same = planned_ && planned_for_.world == experiment.world &&
                      planned_for_.planner == experiment.planner && planned_for_.vehicle == experiment.vehicle;
    if (same) return;
    planned_ = PlanWorld(experiment, experiment.planner);
    planned_for_ = experiment;
    drivers_.clear();
    names_.clear();
    for (const std::string& controller : controllers_) {
      try {
        drivers_.emplace_back(controller, MakeDriver(controller, run_, own_, options_.policy, experiment));
        names_.push_back(drivers_.back().second.name);
      } catch (const UsageError& error) {
        if (controllers_.size() == 1 || controller != "pure_pursuit") throw;
        log::Warning("pure_pursuit is left out: {}", error.what());  // it stands beside the policy where it can
      }
    }
  }

  const EvalOptions& options_;
  const RunDirectory& run_;
  const LoadedExperiment& own_;
  Conditions conditions_;
  std::vector<std::string> controllers_, names_;
  std::vector<std::pair<std::string, Driver>> drivers_;  // by controller
  std::optional<PlannedWorld> planned_;
  Experiment planned_for_;
  std::map<std::string, Summaries> summaries_;  // by overrides
  std::vector<StressResult> results_;
};

}  // namespace

int DriveConditions(const EvalOptions& options, const RunDirectory& run, const LoadedExperiment& own) {
  return StressPage(options, run, own).Run();
}

}  // namespace cairn::deploy
