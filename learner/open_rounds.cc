#include "learner/open_rounds.h"

#include <algorithm>
#include <utility>

#include "common/core/check.h"

namespace cairn::learner {

void OpenRounds::Grant(int steps, int extra, int64_t policy_version, bool warm_up) {
  CAIRN_CHECK(rounds_.empty() || rounds_.back().grant.extra == 0, "only the last round has extra steps");
  vehicle_steps_ += steps;
  Round round;
  round.grant = {++newest_, vehicle_steps_, extra, policy_version, warm_up};
  round.missing = int64_t{steps} * num_vehicles_ + extra;
  rounds_.push_back(std::move(round));
}

OpenRounds::Round* OpenRounds::RoundOf(int32_t vehicle, int64_t vehicle_steps) {
  const auto it = std::find_if(rounds_.begin(), rounds_.end(),
                               [&](const Round& r) { return vehicle_steps < r.grant.Target(vehicle); });
  return it == rounds_.end() ? nullptr : &*it;
}

bool OpenRounds::Add(const Segment& segment, int64_t vehicle_steps) {
  Round* round = RoundOf(segment.vehicle, vehicle_steps);
  if (round == nullptr || segment.policy_version != round->grant.policy_version ||
      vehicle_steps + segment.num_steps() > round->grant.Target(segment.vehicle)) {
    return false;
  }
  round->missing -= segment.num_steps();
  round->harvest.segments.push_back(segment);
  return true;
}

void OpenRounds::Add(const EpisodeResult& episode, int64_t vehicle_steps) {
  Round* round = RoundOf(episode.vehicle, vehicle_steps);
  if (round != nullptr) round->harvest.episodes.push_back(episode);
}

// What one vehicle makes arrives in order; only the interleaving of vehicles depends on timing.
Harvest OpenRounds::TakeFront() {
  CAIRN_CHECK(front_complete(), "the oldest round is not complete");
  Harvest harvest = std::move(rounds_.front().harvest);
  rounds_.pop_front();
  const auto by_vehicle = [](const auto& a, const auto& b) { return a.vehicle < b.vehicle; };
  std::stable_sort(harvest.segments.begin(), harvest.segments.end(), by_vehicle);
  std::stable_sort(harvest.episodes.begin(), harvest.episodes.end(), by_vehicle);
  return harvest;
}

std::vector<Control::Round> OpenRounds::granted() const {
  std::vector<Control::Round> granted;
  for (const Round& round : rounds_) granted.push_back(round.grant);
  return granted;
}

int64_t OpenRounds::missing() const {
  int64_t missing = 0;
  for (const Round& round : rounds_) missing += round.missing;
  return missing;
}

}  // namespace cairn::learner
