#pragma once

#include <string>
#include <vector>

#include "learner/checkpoint/run_state.h"
#include "learner/replay/replay_buffer.h"

namespace cairn::learner {

/// Keeps a replay buffer's rows on disk in chunks of a fixed number of rows: a full chunk is written once and never
/// again, so that a checkpoint costs the disk what is new since the last one and a part of one chunk. Owned by the
/// thread that writes checkpoints.
class ReplayChunks {
 public:
  static constexpr int kChunkRows = 16384;

  /// Files go to `directory`; `index` names those that are there already.
  ReplayChunks(std::string directory, const ReplayIndex& index);

  /// Writes what is missing of rows [num_inserted − capacity, num_inserted) and returns where all of them are. The
  /// caller has protected those rows (ReplayBuffer::Protect). Throws Error naming the file; what was written before
  /// stays for the next call.
  ReplayIndex Save(const ReplayBuffer& replay, int64_t num_inserted);

 private:
  ReplayChunk Write(const ReplayBuffer& replay, int64_t first, int rows);

  std::string directory_;
  std::vector<ReplayChunk> chunks_;  // by first row
};

/// Reads the rows back into an empty buffer of the same shape. Throws Error naming the file: missing, cut off, damaged;
/// UsageError when rows of this experiment have another size.
void LoadReplay(const std::string& directory, const ReplayIndex& index, ReplayBuffer* replay);

}  // namespace cairn::learner
