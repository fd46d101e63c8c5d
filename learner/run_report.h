#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/config/experiment.h"
#include "common/rl/summary.h"
#include "learner/algorithms/algorithm.h"
#include "learner/coordinator.h"
#include "learner/logged_experience.h"
#include "learner/metrics/episode_log.h"
#include "learner/metrics/event_writer.h"

namespace cairn::learner {

/// Where a run stands, as the learner counts it.
struct RunCounters {
  std::string phase;
  std::string warning;  ///< what does not work at the moment; empty: nothing
  int64_t env_steps = 0;
  int64_t updates = 0;
  int replay_size = 0;
  CoordinatorCounters stream;
  int64_t consumption_env_steps = -1;
  double consumption_wall_s = -1;
  double stays_solved = 1;
  int64_t rolled_back = 0;  ///< transitions
  int last_solved = -1;
};

/// How a run ended.
struct RunResult {
  bool completed = false;
  EvaluationSummary test;
  std::string policy_tested = "last";
  uint32_t weights_crc32c = 0;
  int64_t bad_updates = 0;
  /// The log that was trained on, and what was found in it.
  std::optional<std::pair<std::string, LogCounters>> log;
};

/// Everything a run tells people: telemetry, TensorBoard, episodes.csv, summary.json, the log. Nothing depends on it.
class RunReport {
 public:
  /// Writes into `run_dir` (empty: telemetry and log only). `launch_us` is MonotonicUs() at the user's command.
  RunReport(Bus* bus, const Experiment& experiment, const std::string& run_dir, int64_t launch_us);

  /// Opens the files; a resumed run goes on after `wall_s` seconds and behind `episode_log_bytes` (−1: a new run).
  /// Throws Error naming the path when one cannot be opened.
  void Open(double wall_s = 0, int64_t episode_log_bytes = -1);

  /// Bytes of episodes.csv so far, all of it handed to the system.
  int64_t FlushEpisodes();

  void OnEpisodes(const std::vector<EpisodeResult>& episodes, int64_t env_steps);
  void OnEvaluation(const EvaluationReport& report, const EvaluationSummary& summary);

  /// Writes what is due: telemetry at 4 Hz, TensorBoard every 2000 env steps (`algorithm` gives the losses).
  void Visit(const RunCounters& counters, Algorithm* algorithm);

  /// Publishes telemetry now.
  void Telemetry(const RunCounters& counters);

  /// Marks the end of training, from which rates are computed.
  void TrainingEnded(const RunCounters& counters);

  /// Writes summary.json beside and renames it.
  void Finish(const RunCounters& counters, const RunResult& result);

  /// Seconds since the launch.
  double wall_s() const;

 private:
  void Scalars(const RunCounters& counters, const UpdateInfo& info);
  template <typename Write>
  void TryToWrite(const Write& write);

  Bus* bus_;
  const Experiment& experiment_;
  const std::string run_dir_;
  const int64_t launch_us_;
  std::unique_ptr<EventWriter> events_;
  std::unique_ptr<EpisodeLog> episode_log_;
  std::deque<EpisodeResult> recent_;  // last 100 training episodes
  UpdateInfo last_info_;              // newest means of each kind
  std::string log_error_;             // why a log file could not be written the last time; empty: it could
  double earlier_wall_s_ = 0;         // of the processes before this one
  double last_success_ = -1;          // newest validation or test
  int64_t next_scalars_ = 0;
  TimePoint last_telemetry_{};
  RunCounters rate_from_;
  TimePoint rate_time_{};
  double env_steps_per_s_ = 0;
  double updates_per_s_ = 0;
  RunCounters started_;  // when training began in this process
  double training_started_s_ = -1;
  double training_ended_s_ = -1;
};

}  // namespace cairn::learner
