#include "learner/open_rounds.h"

#include <algorithm>
#include <utility>

#include "common/core/check.h"

namespace cairn::learner {
namespace {

bool GoesOn(const Segment& a, const Segment& b) {
  return a.vehicle == b.vehicle && a.episode == b.episode && a.end == SegmentEnd::kNone &&
         b.first_step == a.first_step + a.num_steps() && a.policy_version == b.policy_version &&
         a.table_hash == b.table_hash;
}

void Append(const Segment& next, Segment* segment) {
  const auto observation = next.observations.size() / (next.rewards.size() + 1);  // the one at the seam stands in both
  segment->observations.insert(segment->observations.end(),
                               next.observations.begin() + static_cast<std::ptrdiff_t>(observation),
                               next.observations.end());
  segment->actions.insert(segment->actions.end(), next.actions.begin(), next.actions.end());
  segment->rewards.insert(segment->rewards.end(), next.rewards.begin(), next.rewards.end());
  segment->end = next.end;
}

// What was split to fit messages becomes one again, so that windows of n steps do not depend on their size.
void JoinPieces(std::vector<Segment>* segments) {
  size_t last = 0;
  for (size_t i = 1; i < segments->size(); ++i) {
    if (GoesOn((*segments)[last], (*segments)[i])) {
      Append((*segments)[i], &(*segments)[last]);
    } else if (++last != i) {
      (*segments)[last] = std::move((*segments)[i]);
    }
  }
  if (!segments->empty()) segments->resize(last + 1);
}

}  // namespace

int64_t OpenRounds::Grant(int steps, int extra, int64_t policy_version, bool warm_up, bool save) {
  CAIRN_CHECK(rounds_.empty() || rounds_.back().grant.extra == 0, "only the last round has extra steps");
  vehicle_steps_ += steps;
  Round round;
  round.grant = {++newest_, vehicle_steps_, extra, policy_version, warm_up, save};
  round.state = {steps, extra, warm_up, {policy_version, 0, {}}};
  for (size_t v = 0; v < granted_to_.size(); ++v) {
    const int64_t target = std::max(granted_to_[v], round.grant.Target(static_cast<int32_t>(v)));
    round.missing += target - granted_to_[v];
    granted_to_[v] = target;
  }
  if (save) round.harvest.vehicles.resize(granted_to_.size());
  const int64_t granted = round.missing;
  rounds_.push_back(std::move(round));
  return granted;
}

void OpenRounds::Restore(int64_t rounds, std::vector<int64_t> steps) {
  CAIRN_CHECK(rounds_.empty() && steps.size() == granted_to_.size());
  newest_ = rounds;
  vehicle_steps_ = *std::min_element(steps.begin(), steps.end());
  granted_to_ = std::move(steps);
}

bool OpenRounds::level() const {
  return std::all_of(granted_to_.begin(), granted_to_.end(), [this](int64_t s) { return s == granted_to_.front(); });
}

void OpenRounds::Passed(int32_t vehicle, const VehicleState& state) {
  for (Round& round : rounds_) {
    if (round.grant.save && round.grant.Target(vehicle) == state.steps) {
      round.harvest.vehicles[static_cast<size_t>(vehicle)] = state;
    }
  }
}

std::vector<RoundState> OpenRounds::open() const {
  std::vector<RoundState> open;
  for (const Round& round : rounds_) open.push_back(round.state);
  return open;
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
  JoinPieces(&harvest.segments);
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
