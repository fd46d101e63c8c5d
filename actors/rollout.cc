#include "actors/rollout.h"

#include <algorithm>

#include "actors/blob.h"
#include "common/core/check.h"

namespace cairn::actors {

Rollout::Rollout(std::shared_ptr<const Scene> scene)
    : scene_(std::move(scene)),
      observation_size_(ObservationSize(scene_->experiment())),
      action_size_(static_cast<size_t>(scene_->experiment().vehicle.action_size())) {}

void Rollout::Assign(const std::vector<int32_t>& vehicles, const std::vector<int32_t>& next_episode,
                     const std::vector<int64_t>& steps_done, const std::vector<Bytes>& states) {
  std::vector<VehicleState> assigned;
  for (size_t i = 0; i < vehicles.size(); ++i) {
    const auto kept = std::find_if(vehicles_.begin(), vehicles_.end(),
                                   [&](const VehicleState& v) { return v.environment && v.id == vehicles[i]; });
    if (kept != vehicles_.end()) {
      assigned.push_back(std::move(*kept));
      continue;
    }
    VehicleState vehicle;
    vehicle.id = vehicles[i];
    vehicle.episode = vehicle.start_episode = next_episode[i];
    vehicle.transitions = steps_done[i];
    vehicle.environment = std::make_unique<Environment>(scene_);
    vehicle.observation.resize(static_cast<size_t>(observation_size_));
    StartEpisode(&vehicle);
    if (i < states.size() && !states[i].empty()) LoadVehicle(states[i], &vehicle);
    assigned.push_back(std::move(vehicle));
  }
  vehicles_ = std::move(assigned);
  observations_.resize(vehicles_.size() * static_cast<size_t>(observation_size_));
  noise_.resize(vehicles_.size() * action_size_);
  actions_.resize(vehicles_.size() * action_size_);
}

RandomStream Rollout::ExplorationStream(const VehicleState& vehicle) const {
  return {scene_->experiment().seed, RandomPurpose::kExploration, static_cast<uint32_t>(vehicle.id),
          static_cast<uint32_t>(vehicle.episode)};
}

void Rollout::StartEpisode(VehicleState* vehicle) {
  vehicle->environment->ResetTraining(vehicle->id, vehicle->episode, vehicle->start_episode);
  vehicle->exploration = ExplorationStream(*vehicle);
  vehicle->environment->Observe(vehicle->observation.data());
  vehicle->step = 0;
  vehicle->segment = Segment{};
}

Bytes Rollout::SaveVehicle(int index) const {
  const VehicleState& vehicle = vehicles_[static_cast<size_t>(index)];
  CAIRN_CHECK(vehicle.segment.rewards.empty(), "vehicle {} has an open segment", vehicle.id);
  BlobWriter blob;
  blob.Put(vehicle.episode);
  blob.Put(vehicle.start_episode);
  blob.Put(vehicle.step);
  blob.Put(vehicle.exploration.position());
  blob.PutBytes(vehicle.environment->Save());
  const std::string bytes = blob.Take();
  return {bytes.begin(), bytes.end()};
}

void Rollout::LoadVehicle(const Bytes& state, VehicleState* vehicle) {
  const std::string bytes(state.begin(), state.end());
  BlobReader blob(bytes);
  blob.Get(vehicle->episode);
  blob.Get(vehicle->start_episode);
  blob.Get(vehicle->step);
  uint64_t exploration = 0;
  blob.Get(exploration);
  vehicle->environment->Load(blob.GetBytes());
  blob.Finish();
  vehicle->exploration = ExplorationStream(*vehicle);
  vehicle->exploration.SetPosition(exploration);
  vehicle->environment->Observe(vehicle->observation.data());
}

// The draw is the last of the episode's exploration stream, so it depends on the vehicle's own history alone.
bool Rollout::RetriesStart(VehicleState& vehicle, Outcome outcome) const {
  return outcome == Outcome::kCollision &&
         vehicle.exploration.Uniform() < scene_->experiment().environment.retry_failed_start;
}

void Rollout::Step(const std::vector<int>& indices, const RolloutContext& context) {
  Act(indices, context);
  for (size_t row = 0; row < indices.size(); ++row) {
    Advance(&vehicles_[static_cast<size_t>(indices[row])], actions_.data() + row * action_size_, context);
  }
}

void Rollout::Act(const std::vector<int>& indices, const RolloutContext& context) {
  const auto observation_size = static_cast<size_t>(observation_size_);
  for (size_t row = 0; row < indices.size(); ++row) {
    VehicleState& vehicle = vehicles_[static_cast<size_t>(indices[row])];
    std::copy(vehicle.observation.begin(), vehicle.observation.end(), observations_.begin() + row * observation_size);
    for (size_t a = 0; a < action_size_; ++a) {
      const size_t at = row * action_size_ + a;
      if (context.warm_up) {
        actions_[at] = static_cast<float>(vehicle.exploration.Uniform(-1.0, 1.0));
      } else {
        noise_[at] = static_cast<float>(vehicle.exploration.Normal());
      }
    }
  }
  if (context.warm_up) return;
  context.policy->Explore(observations_.data(), static_cast<int>(indices.size()), noise_.data(),
                          static_cast<float>(scene_->experiment().learner.action_noise), actions_.data());
}

void Rollout::Advance(VehicleState* vehicle, const float* action, const RolloutContext& context) {
  Segment& segment = vehicle->segment;
  if (segment.rewards.empty()) {
    segment.vehicle = vehicle->id;
    segment.episode = vehicle->episode;
    segment.first_step = vehicle->step;
    segment.table_hash = context.table_hash;
    segment.policy_incarnation = context.policy_incarnation;
    segment.policy_version = context.policy_version;
    segment.observations = vehicle->observation;
  }
  CAIRN_DCHECK(segment.policy_version == context.policy_version && segment.table_hash == context.table_hash);
  const StepResult result = vehicle->environment->Step(action);
  if (vehicle->environment->episode().outcome == Outcome::kDiverged) {
    return EndEpisode(vehicle, SegmentEnd::kTruncated, context.policy_version);
  }
  vehicle->environment->Observe(vehicle->observation.data());
  segment.observations.insert(segment.observations.end(), vehicle->observation.begin(), vehicle->observation.end());
  segment.actions.insert(segment.actions.end(), action, action + action_size_);
  segment.rewards.push_back(result.reward);
  ++vehicle->step;
  ++vehicle->transitions;
  ++env_steps_;
  if (result.end != SegmentEnd::kNone) EndEpisode(vehicle, result.end, context.policy_version);
}

void Rollout::EndEpisode(VehicleState* vehicle, SegmentEnd end, int64_t policy_version) {
  CloseSegment(vehicle, end);
  EpisodeResult episode = vehicle->environment->episode();
  episode.policy_version = policy_version;
  episodes_.push_back(episode);
  ++num_episodes_;
  ++vehicle->episode;
  if (!RetriesStart(*vehicle, episode.outcome)) vehicle->start_episode = vehicle->episode;
  StartEpisode(vehicle);
}

void Rollout::CloseSegment(VehicleState* vehicle, SegmentEnd end) {
  if (vehicle->segment.rewards.empty()) return;
  vehicle->segment.end = end;
  segments_.push_back(std::move(vehicle->segment));
  vehicle->segment = Segment{};
}

std::vector<Segment> Rollout::TakeSegments() {
  for (VehicleState& vehicle : vehicles_) CloseSegment(&vehicle, SegmentEnd::kNone);
  std::vector<Segment> taken;
  taken.swap(segments_);
  return taken;
}

std::vector<EpisodeResult> Rollout::TakeEpisodes() {
  std::vector<EpisodeResult> taken;
  taken.swap(episodes_);
  return taken;
}

}  // namespace cairn::actors
