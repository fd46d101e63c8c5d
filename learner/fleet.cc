#include "learner/fleet.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"
#include "common/core/log.h"

namespace cairn::learner {
namespace {

// A holder that was heard this recently is alive, and a second one with its id is refused.
constexpr auto kHolderAlive = std::chrono::seconds(3);

bool AllFinite(const std::vector<float>& values) {
  // The sum of x·0 is NaN exactly when some x is not finite; it vectorises where an early exit would not.
  float sum = 0;
  for (const float x : values) sum += x * 0.0f;
  return sum == 0.0f;
}

void AppendDifference(const char* field, const std::string& theirs, const std::string& ours, std::string* text) {
  if (theirs == ours) return;
  if (!text->empty()) *text += ", ";
  *text += fmt::format("{} is {} (the learner's: {})", field, theirs, ours);
}

// What the last owner had begun is over, unless the next one goes on from its state.
void EndOpenEpisode(VehicleRecord* vehicle) { vehicle->open = vehicle->open && !vehicle->environment.empty(); }

}  // namespace

Fleet::Fleet(int num_actors, int num_vehicles, uint64_t experiment_hash, int observation_size, std::string git_revision)
    : num_actors_(num_actors),
      experiment_hash_(experiment_hash),
      observation_size_(observation_size),
      git_revision_(std::move(git_revision)),
      vehicles_(static_cast<size_t>(num_vehicles)) {}

void Fleet::Restore(const CoordinatorState& state) {
  CAIRN_CHECK(actors_.empty() && state.vehicles.size() == vehicles_.size());
  for (size_t v = 0; v < vehicles_.size(); ++v) {
    static_cast<VehicleState&>(vehicles_[v]) = state.vehicles[v];
    vehicles_[v].open = vehicles_[v].open && !vehicles_[v].environment.empty();
  }
  disturbed_ = state.counters.disturbed;
}

int Fleet::HomeActor(int vehicle) const {
  const auto v = static_cast<int64_t>(vehicle);
  const auto n = static_cast<int64_t>(vehicles_.size());
  // The largest i with i V / N ≤ v.
  return static_cast<int>(((v + 1) * num_actors_ - 1) / n);
}

std::string Fleet::Differences(const Hello& hello) const {
  std::string text;
  AppendDifference("protocol", std::to_string(hello.protocol), std::to_string(kProtocolVersion), &text);
  AppendDifference("git_revision", hello.git_revision, git_revision_, &text);
  AppendDifference("experiment_hash", fmt::format("{:016x}", hello.experiment_hash),
                   fmt::format("{:016x}", experiment_hash_), &text);
  AppendDifference("observation_size", std::to_string(hello.observation_size), std::to_string(observation_size_),
                   &text);
  if (hello.actor_id >= num_actors_) {
    AppendDifference("actor_id", std::to_string(hello.actor_id), fmt::format("0 to {}", num_actors_ - 1), &text);
  }
  return text;
}

Welcome Fleet::Join(const Hello& hello, TimePoint now) {
  Welcome refusal;
  refusal.incarnation = incarnation_;
  refusal.session = hello.session;
  refusal.reason = Differences(hello);
  if (!refusal.reason.empty()) {
    refusal.status = Welcome::Status::kRefused;
    return refusal;
  }
  const auto holder = actors_.find(hello.actor_id);
  if (holder != actors_.end()) {
    const ActorRecord& record = holder->second;
    if (record.session == hello.session) return Assignment(record);
    if (hello.generation <= record.generation && now - record.last_heard < kHolderAlive) {
      refusal.status = Welcome::Status::kIdTaken;
      refusal.reason = fmt::format("actor id {} is held by a living process", hello.actor_id);
      return refusal;
    }
  }
  disturbed_ = disturbed_ || started_;
  ActorRecord record;
  record.actor_id = hello.actor_id;
  record.session = hello.session;
  record.generation = hello.generation;
  record.last_heard = now;
  record.assignment = ++assignment_;
  actors_[hello.actor_id] = record;
  for (size_t v = 0; v < vehicles_.size(); ++v) {
    VehicleRecord& vehicle = vehicles_[v];
    if (vehicle.owner == -1 && HomeActor(static_cast<int>(v)) == hello.actor_id) vehicle.owner = hello.actor_id;
    if (vehicle.owner == hello.actor_id) EndOpenEpisode(&vehicle);
  }
  log::Info("actor {} joined: session {:016x}, generation {}, {}", hello.actor_id, hello.session, hello.generation,
            hello.isa);
  return Assignment(record);
}

ActorRecord* Fleet::Find(int64_t session) {
  const auto it = std::find_if(actors_.begin(), actors_.end(),
                               [session](const auto& entry) { return entry.second.session == session; });
  return it == actors_.end() ? nullptr : &it->second;
}

Welcome Fleet::Assignment(const ActorRecord& actor) const {
  Welcome welcome;
  welcome.incarnation = incarnation_;
  welcome.session = actor.session;
  welcome.assignment = actor.assignment;
  for (size_t v = 0; v < vehicles_.size(); ++v) {
    if (vehicles_[v].owner != actor.actor_id) continue;
    welcome.vehicle.push_back(static_cast<int32_t>(v));
    welcome.next_episode.push_back(vehicles_[v].next_episode);
    welcome.steps_done.push_back(vehicles_[v].steps);
    welcome.state_bytes.push_back(static_cast<int32_t>(vehicles_[v].environment.size()));
  }
  return welcome;
}

Fleet::Verdict Fleet::Judge(const ActorRecord& actor, const Segment& segment) const {
  if (segment.vehicle < 0 || segment.vehicle >= static_cast<int32_t>(vehicles_.size())) return Verdict::kForeign;
  const VehicleRecord& vehicle = vehicles_[static_cast<size_t>(segment.vehicle)];
  if (vehicle.owner != actor.actor_id) return Verdict::kForeign;
  if (segment.episode < vehicle.episode) return Verdict::kDuplicate;
  if (segment.episode == vehicle.episode) {
    if (segment.first_step < vehicle.next_step) return Verdict::kDuplicate;
    if (!vehicle.open || segment.first_step > vehicle.next_step) return Verdict::kGap;
  } else if ((vehicle.open && vehicle.diverged != vehicle.episode) || segment.episode != vehicle.next_episode ||
             segment.first_step != 0) {
    return Verdict::kGap;
  }
  if (!AllFinite(segment.observations) || !AllFinite(segment.actions) || !AllFinite(segment.rewards)) {
    return Verdict::kNotFinite;
  }
  return Verdict::kSound;
}

void Fleet::Accept(const Segment& segment) {
  VehicleRecord& vehicle = vehicles_[static_cast<size_t>(segment.vehicle)];
  vehicle.episode = segment.episode;
  vehicle.next_episode = segment.episode + 1;
  vehicle.next_step = segment.first_step + segment.num_steps();
  vehicle.open = segment.end == SegmentEnd::kNone || segment.end == SegmentEnd::kCut;
  vehicle.steps += segment.num_steps();
  vehicle.environment.clear();
}

void Fleet::CloseDiverged(const ActorRecord& actor, const EpisodeResult& episode) {
  if (episode.vehicle < 0 || episode.vehicle >= static_cast<int32_t>(vehicles_.size())) return;
  VehicleRecord& vehicle = vehicles_[static_cast<size_t>(episode.vehicle)];
  if (vehicle.owner == actor.actor_id) vehicle.diverged = episode.episode;
}

std::vector<int64_t> Fleet::Reassign(int32_t actor_id) {
  std::vector<ActorRecord*> others;
  for (auto& [id, record] : actors_) {
    if (id != actor_id) others.push_back(&record);
  }
  std::vector<int64_t> changed;
  if (others.empty()) return changed;
  actors_.erase(actor_id);
  disturbed_ = true;
  size_t next = 0;
  for (VehicleRecord& vehicle : vehicles_) {
    if (vehicle.owner != actor_id) continue;
    vehicle.owner = others[next++ % others.size()]->actor_id;
    EndOpenEpisode(&vehicle);
  }
  for (ActorRecord* record : others) {
    record->assignment = ++assignment_;
    changed.push_back(record->session);
  }
  return changed;
}

}  // namespace cairn::learner
