#pragma once

#include <cstdint>
#include <string>

#include "common/rl/episode.h"
#include "learner/metrics/log_file.h"

namespace cairn::learner {

/// episodes.csv of a run directory: one line an episode in the order in which the learner accepted them. The columns
/// that depend on the wall clock stand last, so that the others compare equal between two LOCKSTEP runs. One thread.
class EpisodeLog {
 public:
  /// Creates the file, or with `keep_bytes` ≥ 0 goes on behind that many bytes of it, where ids go on too. Throws
  /// Error naming the path.
  explicit EpisodeLog(const std::string& path, int64_t keep_bytes = -1);

  /// `env_steps`: transitions accepted when the episode arrived; `wall_s`: seconds since the run's launch.
  /// Throws Error naming the path and the system's reason (disk full, …).
  void Add(const EpisodeResult& episode, int64_t env_steps, double wall_s);

  /// Hands everything to the system. Throws as Add.
  void Flush() { file_.Flush(); }

  /// Bytes in the file after a Flush.
  int64_t size() const { return file_.size(); }

 private:
  int64_t next_id_;
  LogFile file_;
};

}  // namespace cairn::learner
