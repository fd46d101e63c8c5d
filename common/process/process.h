#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "common/bus/bus.h"
#include "common/config/load.h"
#include "common/config/process_options.h"

namespace cairn {

/// What the three processes of a run have in common: their options, the resolved experiment, the run's key, a session
/// id, and the rule that they end when they are told to or when the launcher is gone.
class Process {
 public:
  Process(ProcessKind kind, ProcessOptions options);

  const ProcessOptions& options() const { return options_; }
  const Experiment& experiment() const { return loaded_.experiment; }
  uint64_t experiment_hash() const { return loaded_.hash; }
  const std::string& resolved_text() const { return loaded_.resolved_text; }
  int64_t session() const { return session_; }
  BusConfig MakeBusConfig() const;

  /// Calls `stop` (on another thread, once) at SIGINT, SIGTERM or the launcher's end instead of ending at once.
  void OnStop(std::function<void()> stop);

  /// Called by the watching thread; ends the process when nobody asked to be told.
  void RequestStop();

 private:
  ProcessOptions options_;
  LoadedExperiment loaded_;
  std::optional<RunKey> key_;
  int64_t session_;
  std::mutex mutex_;  // guards on_stop_
  std::function<void()> on_stop_;
};

/// The main of each process: checks the CPU, reads the command line and the experiment, opens the log, watches signals
/// and the launcher's pipe on a thread, runs `body`. An Error is one line on stderr and in the log, exit status 1; a
/// UsageError 2.
int RunProcess(ProcessKind kind, int argc, char** argv, const std::function<void(Process&)>& body);

}  // namespace cairn
