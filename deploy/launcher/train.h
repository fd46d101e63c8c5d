#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/config/load.h"
#include "deploy/launcher/status_line.h"

namespace cairn::deploy {

/// What was typed after `cairn train`.
struct TrainOptions {
  std::string file;
  std::string run_dir;  ///< empty: runs/<name>-<date>-<time>
  std::string resume;   ///< run directory to go on in, instead of `file`, `run_dir` and overrides; empty: none
  int actors = 0;       ///< 0: DefaultActors
  std::vector<std::string> overrides;
  PlaceArguments place;  ///< --map, --robot, --goal, --start
  bool quiet = false;
  bool insecure = false;        ///< no key though other hosts can reach the run (ttl ≥ 1)
  std::string replay_log;       ///< LCM log to train on instead of what actors make; empty: none
  std::string replay_key;       ///< file with the key it is sealed with; empty: none
  int max_restarts = 10;        ///< of all processes together within a minute
  int64_t launch_utime_us = 0;  ///< MonotonicUs() at the start of main
};

/// Newest status of the run, empty while there is none. Called from the main thread several times a second.
using StatusSource = std::function<std::optional<RunStatus>()>;

/// Makes the source when the run's ports and id are known; called after the private network has been entered.
using MakeStatusSource = std::function<StatusSource(const BusConfig&)>;

/// Runs an experiment to its end: checks, network, ports, run directory, processes, status line. Returns the exit code;
/// throws UsageError or Error with one line for everything that goes wrong.
int Train(const TrainOptions& options, const MakeStatusSource& make_status_source);

}  // namespace cairn::deploy
