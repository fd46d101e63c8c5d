#include "actors/rollout.h"

#include <algorithm>

#include "common/core/check.h"

namespace cairn::actors {

Rollout::Rollout(std::shared_ptr<Course> course)
    : course_(std::move(course)),
      observation_size_(ObservationSize(experiment())),
      action_size_(static_cast<size_t>(experiment().vehicle.action_size())) {}

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
    VehicleState vehicle(experiment().planner);
    vehicle.id = vehicles[i];
    vehicle.episode = vehicle.start_episode = next_episode[i];
    vehicle.transitions = steps_done[i];
    vehicle.environment = std::make_unique<Environment>(course_->home());
    vehicle.observation.resize(static_cast<size_t>(observation_size_));
    if (i < states.size() && !states[i].empty()) TakeState(states[i], &vehicle);
    TryBegin(&vehicle);
    assigned.push_back(std::move(vehicle));
  }
  vehicles_ = std::move(assigned);
  observations_.resize(vehicles_.size() * static_cast<size_t>(observation_size_));
  noise_.resize(vehicles_.size() * action_size_);
  actions_.resize(vehicles_.size() * action_size_);
}

RandomStream Rollout::ExplorationStream(const VehicleState& vehicle) const {
  return {experiment().seed, RandomPurpose::kExploration, static_cast<uint32_t>(vehicle.id),
          static_cast<uint32_t>(vehicle.episode)};
}

// Begins the vehicle's episode, or goes on with the one that it brought along, once its table is here; the next one's
// is asked for meanwhile.
void Rollout::TryBegin(VehicleState* vehicle) {
  vehicle->stage = Stage::kWaiting;
  std::optional<Scene> scene = course_->Training(vehicle->id, vehicle->start_episode);
  if (!scene) return;
  const bool goes_on = !vehicle->state.empty();
  if (goes_on && vehicle->mender.active()) {  // it stood on this table
    auto table = course_->MendedTable(*scene, vehicle->mender.marks());
    if (table == nullptr) return;
    scene->SetTable(std::move(table));
  }
  vehicle->environment->Enter(*scene);
  vehicle->environment->ResetTraining(vehicle->id, vehicle->episode, vehicle->start_episode);
  vehicle->exploration = ExplorationStream(*vehicle);
  vehicle->step = 0;
  vehicle->segment = Segment{};
  vehicle->stage = Stage::kRunning;
  if (goes_on) {
    LoadVehicle(vehicle);
  } else {
    vehicle->mender.Begin(scene->experiment().world.seed);
    if (!vehicle->mender.marks().empty()) TryMend(vehicle);
  }
  if (vehicle->stage == Stage::kMending) TryMend(vehicle);
  vehicle->environment->Observe(vehicle->observation.data());
  course_->PrefetchTraining(vehicle->id, vehicle->episode + 1);
}

void Rollout::TryMend(VehicleState* vehicle) {
  auto table = course_->MendedTable(vehicle->environment->scene(), vehicle->mender.marks());
  vehicle->stage = table == nullptr ? Stage::kMending : Stage::kRunning;
  if (table == nullptr) return;
  vehicle->environment->SetTable(std::move(table));
  vehicle->environment->Observe(vehicle->observation.data());
}

// What a step has shown. A new table cuts the segment, whose last observation stands on the old one (DESIGN 24).
void Rollout::Look(VehicleState* vehicle) {
  if (!vehicle->mender.active()) return;
  const Environment& environment = *vehicle->environment;
  if (!vehicle->mender.Report(environment.FindSurprises(), environment.episode().duration)) return;
  if (environment.episode().outcome != Outcome::kRunning) return;
  CloseSegment(vehicle, SegmentEnd::kCut);
  TryMend(vehicle);
}

bool Rollout::Ready(int index) {
  VehicleState& vehicle = vehicles_[static_cast<size_t>(index)];
  if (vehicle.stage == Stage::kWaiting) TryBegin(&vehicle);
  if (vehicle.stage == Stage::kMending) TryMend(&vehicle);
  return vehicle.stage == Stage::kRunning;
}

Bytes Rollout::SaveVehicle(int index) const {
  const VehicleState& vehicle = vehicles_[static_cast<size_t>(index)];
  CAIRN_CHECK(vehicle.segment.rewards.empty(), "vehicle {} has an open segment", vehicle.id);
  if (!vehicle.state.empty()) return vehicle.state;  // it has not gone on yet
  BlobWriter blob;
  blob.Put(vehicle.episode);
  blob.Put(vehicle.start_episode);
  blob.Put(vehicle.stage);
  if (vehicle.mender.active()) vehicle.mender.Write(blob);
  if (vehicle.stage != Stage::kWaiting) {
    blob.Put(vehicle.step);
    blob.Put(vehicle.exploration.position());
    blob.PutBytes(vehicle.environment->Save());
  }
  const std::string bytes = blob.Take();
  return {bytes.begin(), bytes.end()};
}

// The part of a state that tells which table the rest stands on. Of a vehicle that had not begun there is no more.
void Rollout::ReadHead(BlobReader& blob, VehicleState* vehicle) {
  blob.Get(vehicle->episode);
  blob.Get(vehicle->start_episode);
  blob.Get(vehicle->stage);
  if (vehicle->mender.active()) vehicle->mender.Read(blob);
}

void Rollout::TakeState(const Bytes& state, VehicleState* vehicle) {
  const std::string bytes(state.begin(), state.end());
  BlobReader blob(bytes);
  ReadHead(blob, vehicle);
  if (vehicle->stage != Stage::kWaiting) vehicle->state = state;
}

void Rollout::LoadVehicle(VehicleState* vehicle) {
  const std::string bytes(vehicle->state.begin(), vehicle->state.end());
  BlobReader blob(bytes);
  ReadHead(blob, vehicle);
  blob.Get(vehicle->step);
  uint64_t exploration = 0;
  blob.Get(exploration);
  vehicle->environment->Load(blob.GetBytes());
  blob.Finish();
  vehicle->exploration.SetPosition(exploration);
  vehicle->state.clear();
}

// The draw is the last of the episode's exploration stream, so it depends on the vehicle's own history alone.
bool Rollout::RetriesStart(VehicleState& vehicle, Outcome outcome) const {
  return outcome == Outcome::kCollision && vehicle.exploration.Uniform() < experiment().environment.retry_failed_start;
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
                          static_cast<float>(experiment().learner.action_noise), actions_.data());
}

void Rollout::Advance(VehicleState* vehicle, const float* action, const RolloutContext& context) {
  Segment& segment = vehicle->segment;
  if (segment.rewards.empty()) {
    segment.vehicle = vehicle->id;
    segment.episode = vehicle->episode;
    segment.first_step = vehicle->step;
    segment.table_hash = vehicle->environment->scene().lookup().table_hash();
    segment.policy_incarnation = context.policy_incarnation;
    segment.policy_version = context.policy_version;
    segment.observations = vehicle->observation;
  }
  CAIRN_DCHECK(segment.policy_version == context.policy_version);
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
  Look(vehicle);
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
  TryBegin(vehicle);
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
