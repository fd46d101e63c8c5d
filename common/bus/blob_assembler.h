#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/bus/codec.h"
#include "common/core/hash.h"

namespace cairn {

/// Collects the chunks of one blob, in any order, until it is complete and has the wanted content hash.
class BlobAssembler {
 public:
  static constexpr int32_t kMaxBlobBytes = 1 << 30;

  explicit BlobAssembler(uint64_t hash) : hash_(hash) {}

  /// Takes a chunk of this blob; others and ones that disagree with the first about sizes are ignored.
  void Add(const TableChunk& chunk) {
    if (chunk.hash != hash_ || complete_ || chunk.total_bytes < 1 || chunk.total_bytes > kMaxBlobBytes) return;
    if (bytes_.empty()) Start(chunk);
    if (chunk.total_bytes != static_cast<int32_t>(bytes_.size()) || chunk.chunk_bytes != chunk_bytes_) return;
    const auto index = static_cast<size_t>(chunk.chunk);
    const size_t at = index * static_cast<size_t>(chunk_bytes_);
    if (index >= have_.size() || chunk.data.size() != std::min(bytes_.size() - at, static_cast<size_t>(chunk_bytes_))) {
      return;
    }
    if (have_[index]) return;
    std::copy(chunk.data.begin(), chunk.data.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
    have_[index] = true;
    if (--missing_ == 0) Finish();
  }

  bool complete() const { return complete_; }
  const Bytes& bytes() const { return bytes_; }
  uint64_t hash() const { return hash_; }

  /// First missing chunk and how many from there on are missing in a row; 0, 0 before the first chunk came.
  std::pair<int32_t, int32_t> FirstGap() const {
    const auto first = std::find(have_.begin(), have_.end(), false);
    const auto last = std::find(first, have_.end(), true);
    return {static_cast<int32_t>(first - have_.begin()), static_cast<int32_t>(last - first)};
  }

 private:
  void Start(const TableChunk& chunk) {
    chunk_bytes_ = chunk.chunk_bytes;
    bytes_.assign(static_cast<size_t>(chunk.total_bytes), 0);
    missing_ = (bytes_.size() + static_cast<size_t>(chunk_bytes_) - 1) / static_cast<size_t>(chunk_bytes_);
    have_.assign(missing_, false);
  }

  // A wrong hash means that somebody sent rubbish under this name: start over.
  void Finish() {
    complete_ = ContentHash(bytes_.data(), bytes_.size()) == hash_;
    if (complete_) return;
    bytes_.clear();
    have_.clear();
  }

  uint64_t hash_;
  int32_t chunk_bytes_ = 0;
  size_t missing_ = 0;
  bool complete_ = false;
  Bytes bytes_;
  std::vector<bool> have_;
};

}  // namespace cairn
