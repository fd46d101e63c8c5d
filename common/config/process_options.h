#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/experiment.h"
#include "common/config/load.h"

namespace cairn {

enum class ProcessKind { kPlanner, kLearner, kActor };

/// "planner", "learner", "actor"; the program is "cairn-" + this.
const char* ProcessName(ProcessKind kind);

/// What a process of a run is told on its command line: written by the launcher (or by hand or by Slurm on another
/// host), read by the process's main. `--help` of each program lists them.
struct ProcessOptions {
  std::string experiment;  ///< FILE: the resolved file of the run; required
  std::string run_dir;     ///< --run-dir: where the process may write; empty: nowhere
  int64_t run_id = 0;      ///< --run-id: hexadecimal, > 0, the same for all processes of a run; required
  std::optional<TransportConfig> transport;  ///< --lcm-url; left out: transport of the experiment
  std::string key;                           ///< --key: file with the run's key; empty: none
  bool insecure = false;                     ///< --insecure: do without a key though ttl ≥ 1
  int parent_fd = -1;     ///< --parent-fd: pipe whose end of file says that the launcher is gone; -1: none
  std::string log_level;  ///< --log-level: debug, info (default), warning or error

  // cairn-learner
  bool resume = false;          ///< --resume: go on from the newest checkpoint of --run-dir
  int actors = 1;               ///< --actors: how many actors to expect at the start
  std::string replay_log;       ///< --replay-log: LCM log to train on instead of what actors make; empty: none
  std::string replay_key;       ///< --replay-key: file with the key that it is sealed with; empty: none
  int64_t launch_utime_us = 0;  ///< --launch-utime-us: MonotonicUs() when `cairn train` began; 0: now

  // cairn-actor
  int actor_id = 0;    ///< --actor-id: 0 … actors − 1
  int generation = 0;  ///< --generation: how many processes had this id before
};

/// Reads a command line. Empty when --help or --version was asked for and printed: end with 0.
/// Throws UsageError naming the option.
std::optional<ProcessOptions> ParseProcessOptions(ProcessKind kind, int argc, const char* const* argv);

/// The command line, without the program, that ParseProcessOptions reads back to the same options.
std::vector<std::string> ToArguments(ProcessKind kind, const ProcessOptions& options);

/// Loads options.experiment and puts the transport of the command line in place of the file's. Throws UsageError when
/// other hosts can reach the run (ttl ≥ 1) and there is neither a key nor --insecure.
LoadedExperiment LoadProcessExperiment(const ProcessOptions& options);

}  // namespace cairn
