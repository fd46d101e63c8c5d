#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/config/load.h"
#include "deploy/launcher/network.h"

namespace cairn::deploy {

/// The directory of one run: experiment.textproto, map/ and roadmap/ if it has them, run.json, log/, checkpoints/, with
/// ttl ≥ 1 the run's key, and what the learner adds.
class RunDirectory {
 public:
  /// Creates `path`, or runs/<name>-<date>-<time> when it is empty, with its sub-directories and the experiment as
  /// resolved. Other files in it are left alone; what a run left that ended before its first checkpoint goes into
  /// void-1. Throws UsageError when it already holds a run, Error when it cannot be written (disk full, …); nothing
  /// half-written is left then. `map_file` and `roadmap_file`, if not empty, are copied into map/ and roadmap/.
  static RunDirectory Create(const std::string& path, const std::string& name, const std::string& resolved_text,
                             const std::string& map_file = "", const std::string& roadmap_file = "");

  /// Throws UsageError when `path` already holds a run, unless that ended before its first checkpoint.
  static void CheckVacant(const std::string& path);

  /// A run that was interrupted: as Open, and throws UsageError when there is no checkpoint to go on from or the run
  /// has reached `total_env_steps`.
  static RunDirectory Resume(const std::string& path, int64_t total_env_steps);

  /// A run that exists; throws UsageError naming what is missing.
  static RunDirectory Open(const std::string& path);

  /// Whether there is something for Resume to go on from.
  bool has_checkpoint() const;

  const std::string& path() const { return path_; }
  std::string experiment_file() const { return path_ + "/experiment.textproto"; }
  std::string map_folder() const { return path_ + "/" + kMapFolder; }
  std::string roadmap_folder() const { return path_ + "/" + kRoadmapFolder; }
  std::string info_file() const { return path_ + "/run.json"; }
  std::string key_file() const { return path_ + "/key"; }
  std::string log_file(const std::string& process) const { return path_ + "/log/" + process + ".log"; }
  std::string policy_file(const std::string& which) const { return path_ + "/checkpoints/" + which + ".policy"; }

 private:
  explicit RunDirectory(std::string path) : path_(std::move(path)) {}
  static bool IsVoid(const std::string& path);
  static void SetAside(const std::string& path);
  static void CheckNotLive(const RunDirectory& directory, const std::string& what);

  std::string path_;
};

/// Name of this host.
std::string HostName();

/// run.json: where a run can be met.
struct RunInfo {
  int64_t pid = 0;  ///< of the launcher
  int64_t run_id = 0;
  BusConfig bus;  ///< group, base port and ttl, or broker; written also: how other hosts join, not the key itself
  NetworkInfo network;
  int actors = 0;
  std::string host = HostName();  ///< where it was started
};

/// The command line with which an actor on another host joins a run that leaves this one, given copies of
/// experiment.textproto and key in its directory; N stands for the actor's id.
std::string JoinCommand(const BusConfig& bus);

void WriteRunInfo(const RunDirectory& directory, const RunInfo& info);

/// Whether the run's launcher still lives on this host, in the network that run.json names.
bool IsLive(const RunInfo& info);

/// Throws UsageError naming the file and what is wrong with it.
RunInfo ReadRunInfo(const RunDirectory& directory);

}  // namespace cairn::deploy
