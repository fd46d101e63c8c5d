#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "common/bus/messages.h"

namespace cairn {

/// Puts states of vehicles together from their pieces, which may come in any order and twice. Bounded: one state a
/// vehicle, none larger than a megabyte. Pieces of another number of steps than the first of a vehicle start anew.
class StateAssembler {
 public:
  void Add(const VehicleStatePiece& piece) {
    if (piece.total < 1 || piece.offset < 0) return;
    const auto total = static_cast<size_t>(piece.total);
    if (total > kMaxBytes || static_cast<size_t>(piece.offset) + piece.data.size() > total) return;
    Partial& partial = partial_[piece.vehicle];
    if (partial.steps != piece.steps || partial.bytes.size() != total) {
      partial = {piece.steps, Bytes(total), std::vector<bool>(total), total};
    }
    for (size_t i = 0; i < piece.data.size(); ++i) {
      const size_t at = static_cast<size_t>(piece.offset) + i;
      partial.bytes[at] = piece.data[i];
      partial.missing -= partial.have[at] ? 0 : 1;
      partial.have[at] = true;
    }
  }

  /// The whole state of a vehicle after `steps` transitions; nullptr while pieces are missing.
  const Bytes* Find(int32_t vehicle, int64_t steps) const {
    const auto it = partial_.find(vehicle);
    return it != partial_.end() && it->second.steps == steps && it->second.missing == 0 ? &it->second.bytes : nullptr;
  }

  void Clear() { partial_.clear(); }

 private:
  static constexpr size_t kMaxBytes = 1 << 20;
  struct Partial {
    int64_t steps = -1;
    Bytes bytes;
    std::vector<bool> have;
    size_t missing = 0;
  };
  std::map<int32_t, Partial> partial_;
};

/// A state as pieces of at most `max_bytes`.
inline std::vector<VehicleStatePiece> SplitState(int32_t vehicle, int64_t steps, const Bytes& state, int max_bytes) {
  std::vector<VehicleStatePiece> pieces;
  for (size_t at = 0; at < state.size(); at += static_cast<size_t>(max_bytes)) {
    const size_t end = std::min(state.size(), at + static_cast<size_t>(max_bytes));
    pieces.push_back(
        {vehicle, steps, static_cast<int32_t>(state.size()), static_cast<int32_t>(at),
         Bytes(state.begin() + static_cast<std::ptrdiff_t>(at), state.begin() + static_cast<std::ptrdiff_t>(end))});
  }
  return pieces;
}

}  // namespace cairn
