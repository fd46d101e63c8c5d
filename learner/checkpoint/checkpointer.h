#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/core/clock.h"
#include "learner/checkpoint/replay_chunks.h"
#include "learner/checkpoint/run_fields.h"
#include "learner/checkpoint/run_state.h"
#include "learner/replay/replay_buffer.h"

namespace cairn::learner {

struct CheckpointStatus {
  int64_t env_steps = -1;  ///< of the newest one on disk; −1: none
  int64_t written = 0;     ///< by this process
  std::string error;       ///< why the newest try failed; empty when it did not
};

/// Writes checkpoints on a thread of its own, so that training goes on meanwhile: replay rows that are new, then the
/// file that makes them count, each beside, fsynced and renamed; then it drops what no kept checkpoint needs. A failure
/// (disk full, read-only directory) leaves the older ones as they are and is tried again with the next one.
class Checkpointer {
 public:
  /// Goes on in `directory`, which exists, with what is there: leftovers of an interrupted write are removed. Keeps the
  /// newest `kept` checkpoints.
  Checkpointer(std::string directory, int kept);
  /// Finishes the write under way.
  ~Checkpointer();
  Checkpointer(const Checkpointer&) = delete;
  Checkpointer& operator=(const Checkpointer&) = delete;

  bool busy() const;

  /// Begins to write; not while busy(). The replay's rows so far are protected until they are on disk. Returns at once.
  void Write(RunState state, ReplayBuffer* replay);

  /// Until no write is under way.
  void Wait();

  CheckpointStatus status() const;

 private:
  void Run(const std::stop_token& stop);
  void WriteNow(RunState* state, ReplayBuffer* replay);
  void RemoveUnused();

  const std::string directory_;
  const int kept_;
  // Of the writing thread alone, after construction.
  std::map<std::string, std::vector<std::string>> files_;  // rows' files by checkpoint file
  std::optional<ReplayChunks> chunks_;

  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable changed_;
  std::optional<RunState> next_;
  ReplayBuffer* replay_ = nullptr;
  bool busy_ = false;
  bool stop_ = false;
  CheckpointStatus status_;
  std::jthread thread_;
};

/// Names of the checkpoints in a directory, newest last.
std::vector<std::string> ListCheckpoints(const std::string& directory);

/// The newest checkpoint that is whole, with its replay rows in `replay` (empty before). A damaged one is said loudly,
/// set aside (`.damaged`) and the one before it used. Throws Error when none is whole, UsageError when there is none or
/// when a whole one does not agree with `fields` (CheckFields), of which no file is touched.
RunState LoadNewestCheckpoint(const std::string& directory, const RunFields& fields, ReplayBuffer* replay);

/// The newest checkpoint that can be read, without replay rows; changes nothing. Throws as above.
RunState ReadNewestCheckpoint(const std::string& directory);

}  // namespace cairn::learner
