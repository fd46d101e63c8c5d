#include "common/rl/summary.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn {
namespace {

double PathWeight(const EpisodeResult& result) {
  const double shortest = result.shortest_length, driven = result.path_length;
  if (!std::isfinite(shortest) || driven <= shortest) return 1;
  return shortest / driven;
}

void Add(const EpisodeResult& result, EvaluationSummary& summary) {
  ++summary.trials;
  summary.steps += result.steps;
  summary.filtered_steps += result.filtered_steps;
  summary.mean_clearance += result.min_clearance;
  summary.min_clearance = std::min<double>(summary.min_clearance, result.min_clearance);
  summary.mean_jerk += result.mean_jerk;
  summary.mean_return += result.episode_return;
  if (result.outcome == Outcome::kCollision) ++summary.collisions;
  if (result.outcome == Outcome::kTimeout) ++summary.timeouts;
  if (result.outcome == Outcome::kDiverged) ++summary.diverged;
  if (result.outcome != Outcome::kGoal) return;
  ++summary.successes;
  summary.mean_time_to_goal += result.duration;
  summary.mean_path_length += result.path_length;
  summary.spl += PathWeight(result);
}

}  // namespace

// Wilson: (p̂ + z²/2n ± z √(p̂(1 − p̂)/n + z²/4n²)) / (1 + z²/n).
Interval WilsonInterval(int successes, int trials, double z) {
  if (trials == 0) return {};
  const double n = trials, p = successes / n, zz = z * z;
  const double center = p + zz / (2 * n);
  const double half = z * std::sqrt(p * (1 - p) / n + zz / (4 * n * n));
  const double scale = 1 + zz / n;
  return {std::max(0.0, (center - half) / scale), std::min(1.0, (center + half) / scale)};
}

EvaluationSummary Summarise(std::span<const EpisodeResult> results) {
  EvaluationSummary summary;
  if (results.empty()) return summary;
  summary.min_clearance = std::numeric_limits<double>::infinity();
  for (const EpisodeResult& result : results) Add(result, summary);
  for (double* sum : {&summary.spl, &summary.mean_clearance, &summary.mean_jerk, &summary.mean_return}) {
    *sum /= summary.trials;
  }
  for (double* sum : {&summary.mean_time_to_goal, &summary.mean_path_length}) *sum /= std::max(1, summary.successes);
  summary.success_rate = static_cast<double>(summary.successes) / summary.trials;
  summary.success_interval = WilsonInterval(summary.successes, summary.trials);
  return summary;
}

std::string ToString(const EvaluationSummary& s) {
  return fmt::format(
      "{}/{} solved ({:.3f}–{:.3f}), {} collisions, {} timeouts, {} diverged, {:.2f} s, {:.2f} m, SPL {:.3f}, "
      "clearance {:.1f} mm, jerk {:.1f} m/s³",
      s.successes, s.trials, s.success_interval.low, s.success_interval.high, s.collisions, s.timeouts, s.diverged,
      s.mean_time_to_goal, s.mean_path_length, s.spl, 1e3 * s.min_clearance, s.mean_jerk);
}

}  // namespace cairn
