#include "learner/checkpoint/replay_chunks.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "common/core/check.h"
#include "common/core/files.h"
#include "common/core/hash.h"

namespace cairn::learner {

ReplayChunks::ReplayChunks(std::string directory, const ReplayIndex& index)
    : directory_(std::move(directory)), chunks_(index.chunks) {}

ReplayIndex ReplayChunks::Save(const ReplayBuffer& replay, int64_t num_inserted) {
  ReplayIndex index{num_inserted, replay.row_floats(), {}};
  const int64_t oldest = std::max<int64_t>(0, num_inserted - replay.capacity());
  std::erase_if(chunks_, [&](const ReplayChunk& c) { return c.first + c.rows <= oldest; });
  for (int64_t first = oldest / kChunkRows * kChunkRows; first < num_inserted; first += kChunkRows) {
    const int rows = static_cast<int>(std::min<int64_t>(kChunkRows, num_inserted - first));
    const auto known = std::find_if(chunks_.begin(), chunks_.end(), [&](const ReplayChunk& c) {
      return c.first <= std::max(first, oldest) && c.first + c.rows == first + rows;
    });
    if (known != chunks_.end()) {
      index.chunks.push_back(*known);
      continue;
    }
    // The rows before `oldest` are gone from the buffer; a chunk that has lost some is written short.
    const int64_t begin = std::max(first, oldest);
    const ReplayChunk chunk = Write(replay, begin, static_cast<int>(first + rows - begin));
    std::erase_if(chunks_, [&](const ReplayChunk& c) { return c.first / kChunkRows * kChunkRows == first; });
    chunks_.push_back(chunk);
    index.chunks.push_back(chunk);
  }
  return index;
}

ReplayChunk ReplayChunks::Write(const ReplayBuffer& replay, int64_t first, int rows) {
  ReplayChunk chunk{fmt::format("replay-{:012}-{:05}.rows", first, rows), first, rows, 0};
  const size_t row_bytes = static_cast<size_t>(replay.row_floats()) * sizeof(float);
  std::string bytes(static_cast<size_t>(rows) * row_bytes, '\0');
  for (int i = 0; i < rows; ++i) {
    std::memcpy(bytes.data() + static_cast<size_t>(i) * row_bytes, replay.RowOf(first + i), row_bytes);
  }
  chunk.crc32c = Crc32c(bytes.data(), bytes.size());
  WriteFileAtomically(directory_ + "/" + chunk.file, bytes);
  return chunk;
}

void LoadReplay(const std::string& directory, const ReplayIndex& index, ReplayBuffer* replay) {
  if (index.row_floats != replay->row_floats()) {
    ThrowUsageError("checkpoint {}: replay rows of {} floats, this experiment's have {}", directory, index.row_floats,
                    replay->row_floats());
  }
  const int64_t oldest = std::max<int64_t>(0, index.num_inserted - replay->capacity());
  replay->StartAt(oldest);
  const size_t row_bytes = static_cast<size_t>(replay->row_floats()) * sizeof(float);
  for (const ReplayChunk& chunk : index.chunks) {
    const std::string path = directory + "/" + chunk.file;
    const std::string bytes = ReadFile(path);
    if (bytes.size() != static_cast<size_t>(chunk.rows) * row_bytes) {
      ThrowError("checkpoint {}: {} bytes instead of {} rows of {}", path, bytes.size(), chunk.rows, row_bytes);
    }
    const uint32_t crc = Crc32c(bytes.data(), bytes.size());
    if (crc != chunk.crc32c) {
      ThrowError("checkpoint {}: damaged: CRC32C {:08x}, stored {:08x}", path, crc, chunk.crc32c);
    }
    for (int i = 0; i < chunk.rows; ++i) {
      const int64_t row = chunk.first + i;
      if (row < oldest) continue;
      if (row != replay->num_inserted()) ThrowError("checkpoint {}: row {} is missing", path, replay->num_inserted());
      replay->AppendRow(reinterpret_cast<const float*>(bytes.data() + static_cast<size_t>(i) * row_bytes));
    }
  }
  if (replay->num_inserted() != index.num_inserted) {
    ThrowError("checkpoint {}: {} of {} replay rows", directory, replay->num_inserted(), index.num_inserted);
  }
}

}  // namespace cairn::learner
