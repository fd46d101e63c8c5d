#include "deploy/launcher/summary_json.h"

namespace cairn::deploy {

nlohmann::ordered_json ToJson(const EvaluationSummary& summary) {
  nlohmann::ordered_json json;
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
  json["steps"] = summary.steps;
  json["filtered_steps"] = summary.filtered_steps;
  return json;
}

}  // namespace cairn::deploy
