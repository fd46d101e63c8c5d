#include "actors/experience_batcher.h"

#include <algorithm>

#include "common/bus/state_assembler.h"
#include "common/core/check.h"

namespace cairn::actors {
namespace {

// Encoded sizes, from lcmtypes/experience_t.lcm.
constexpr int kHeaderBytes = 80;
constexpr int kSegmentBytes = 4 * 4 + 1 + 2 * 8;
constexpr int kStateBytes = 4 * 4 + 8;
constexpr int kEpisodeBytes = 2 + 4 * 4 + 8 + 6 * 4;

// Steps [first, first + n) of a segment; only the last piece keeps its end.
Segment Piece(const Segment& s, int first, int n, size_t observation_size, size_t action_size) {
  Segment piece;
  piece.vehicle = s.vehicle;
  piece.episode = s.episode;
  piece.first_step = s.first_step + first;
  piece.end = first + n == s.num_steps() ? s.end : SegmentEnd::kNone;
  piece.table_hash = s.table_hash;
  piece.policy_incarnation = s.policy_incarnation;
  piece.policy_version = s.policy_version;
  const auto f = static_cast<size_t>(first);
  const auto count = static_cast<size_t>(n);
  const float* observations = s.observations.data() + f * observation_size;
  const float* actions = s.actions.data() + f * action_size;
  piece.observations.assign(observations, observations + (count + 1) * observation_size);
  piece.actions.assign(actions, actions + count * action_size);
  piece.rewards.assign(s.rewards.data() + f, s.rewards.data() + f + count);
  return piece;
}

class Packer {
 public:
  Packer(int observation_size, int action_size, int max_bytes)
      : observation_size_(observation_size), action_size_(action_size), max_bytes_(max_bytes) {}

  void Add(Segment segment) {
    const int step_bytes = 4 * (observation_size_ + action_size_ + 1);
    const int fixed = kHeaderBytes + kSegmentBytes + 4 * observation_size_;
    const int max_steps = (max_bytes_ - fixed) / step_bytes;
    if (max_steps < 1) {
      ThrowUsageError("observation: {} entries do not fit a message of {} bytes; switch parts of it off",
                      observation_size_, max_bytes_);
    }
    for (int first = 0; first < segment.num_steps(); first += max_steps) {
      const int n = std::min(max_steps, segment.num_steps() - first);
      Reserve(kSegmentBytes + 4 * observation_size_ + n * step_bytes);
      batch_.back().policy_incarnation = segment.policy_incarnation;
      if (n == segment.num_steps()) {
        batch_.back().segments.push_back(std::move(segment));
        return;
      }
      batch_.back().segments.push_back(
          Piece(segment, first, n, static_cast<size_t>(observation_size_), static_cast<size_t>(action_size_)));
    }
  }

  void Add(const EpisodeResult& episode) {
    Reserve(kEpisodeBytes);
    batch_.back().episodes.push_back(episode);
  }

  void Add(int32_t vehicle, int64_t steps, const Bytes& state) {
    const int room = max_bytes_ - kHeaderBytes - kStateBytes;
    for (VehicleStatePiece& piece : SplitState(vehicle, steps, state, room)) {
      Reserve(kStateBytes + static_cast<int>(piece.data.size()));
      batch_.back().states.push_back(std::move(piece));
    }
  }

  std::vector<Experience> Take() { return std::move(batch_); }

 private:
  // Makes the last message one with room for `bytes` more.
  void Reserve(int bytes) {
    if (batch_.empty() || used_ + bytes > max_bytes_) {
      batch_.emplace_back();
      batch_.back().observation_size = observation_size_;
      batch_.back().action_size = action_size_;
      used_ = kHeaderBytes;
    }
    used_ += bytes;
  }

  int observation_size_, action_size_, max_bytes_;
  int used_ = 0;
  std::vector<Experience> batch_;
};

}  // namespace

std::vector<Experience> PackExperience(std::vector<Segment> segments, const std::vector<EpisodeResult>& episodes,
                                       const std::vector<SavedVehicle>& states, int observation_size, int action_size,
                                       int max_bytes) {
  Packer packer(observation_size, action_size, max_bytes);
  for (const EpisodeResult& episode : episodes) packer.Add(episode);
  for (const SavedVehicle& state : states) packer.Add(state.vehicle, state.steps, state.state);
  for (Segment& segment : segments) packer.Add(std::move(segment));
  return packer.Take();
}

}  // namespace cairn::actors
