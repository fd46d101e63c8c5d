#pragma once

#include <span>
#include <string>

#include "common/rl/episode.h"

namespace cairn {

/// A share and where it may lie.
struct Interval {
  double low = 0;
  double high = 1;
};

/// Wilson score interval of `successes` out of `trials` (Wilson 1927) at `z` standard deviations (1.96: 95 %); [0, 1]
/// without trials.
Interval WilsonInterval(int successes, int trials, double z = 1.959963984540054);

/// What a set of finished episodes shows (DESIGN: success is the goal reached without touching anything).
struct EvaluationSummary {
  int trials = 0;
  int successes = 0;
  int collisions = 0;
  int timeouts = 0;
  int diverged = 0;
  double success_rate = 0;
  Interval success_interval;     ///< 95 %
  double mean_time_to_goal = 0;  ///< of successes [s]; 0 when there is none
  double mean_path_length = 0;   ///< of successes [m]; 0 when there is none
  /// Success weighted by path length (Anderson et al. 2018, equation 1): mean of success · l / max(p, l), l the
  /// roadmap's length from the start and p the way driven. Starts the roadmap does not reach count with weight 1.
  double spl = 0;
  double min_clearance = 0;   ///< smallest over all episodes [m]
  double mean_clearance = 0;  ///< mean over episodes of the smallest [m]
  double mean_jerk = 0;       ///< [m/s³]
  double mean_return = 0;
  int64_t steps = 0;           ///< control steps, all episodes
  int64_t filtered_steps = 0;  ///< those in which the safety filter changed a command
};

EvaluationSummary Summarise(std::span<const EpisodeResult> results);

/// One line for people: "199/200 solved (0.972–0.999), 1 collision, 0 timeouts, 9.80 s, 8.71 m, SPL 0.981, …".
std::string ToString(const EvaluationSummary& summary);

}  // namespace cairn
