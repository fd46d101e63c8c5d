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

// Vehicles of a session that may still live go on with it; others begin a new episode, unless they have a state.
void Fleet::Restore(const CoordinatorState& state) {
  CAIRN_CHECK(actors_.empty() && state.vehicles.size() == vehicles_.size());
  for (const SessionState& session : state.sessions) {
    ActorRecord record;
    record.actor_id = session.actor_id;
    record.session = session.session;
    record.generation = session.generation;
    record.assignment = session.assignment;
    record.joined = false;
    record.stream = ReliableReceiver<Experience>(session.received);
    record.durable = session.received;
    record.accepted = session.accepted;
    record.credit = session.credit;
    assignment_ = std::max(assignment_, session.assignment);
    actors_[session.actor_id] = std::move(record);
  }
  for (size_t v = 0; v < vehicles_.size(); ++v) {
    VehicleRecord& vehicle = vehicles_[v];
    static_cast<VehicleState&>(vehicle) = state.vehicles[v];
    if (!actors_.contains(vehicle.owner)) {
      vehicle.owner = -1;
      EndOpenEpisode(&vehicle);
    }
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
  return text;
}

Welcome Fleet::Refuse(const Hello& hello, Welcome::Status status, std::string reason) const {
  Welcome refusal;
  refusal.incarnation = incarnation_;
  refusal.session = hello.session;
  refusal.status = status;
  refusal.reason = std::move(reason);
  return refusal;
}

Welcome Fleet::Join(const Hello& hello, TimePoint now) {
  const std::string differences = Differences(hello);
  if (!differences.empty()) return Refuse(hello, Welcome::Status::kRefused, differences);
  const auto holder = actors_.find(hello.actor_id);
  if (holder != actors_.end()) {
    ActorRecord& record = holder->second;
    if (record.session == hello.session) {
      if (!record.joined) log::Info("actor {} goes on at {} transitions", record.actor_id, record.accepted);
      record.joined = true;
      record.last_heard = now;
      record.credit = std::max(record.credit, hello.transitions);
      return Assignment(record);
    }
    if (record.joined && hello.generation <= record.generation && now - record.last_heard < kHolderAlive) {
      return Refuse(hello, Welcome::Status::kIdTaken,
                    fmt::format("actor id {} is held by a living process", hello.actor_id));
    }
  }
  if (hello.transitions > 0) {
    return Refuse(hello, Welcome::Status::kUnknown, "the learner does not know what this session has made");
  }
  disturbed_ = disturbed_ || started_;
  ActorRecord record;
  record.actor_id = hello.actor_id;
  record.session = hello.session;
  record.generation = hello.generation;
  record.last_heard = now;
  record.assignment = ++assignment_;
  ActorRecord& joined = actors_[hello.actor_id] = std::move(record);
  for (size_t v = 0; v < vehicles_.size(); ++v) {
    VehicleRecord& vehicle = vehicles_[v];
    if (vehicle.owner == -1 && HomeActor(static_cast<int>(v)) == hello.actor_id) vehicle.owner = hello.actor_id;
    if (vehicle.owner == hello.actor_id) EndOpenEpisode(&vehicle);
  }
  log::Info("actor {} joined: session {:016x}, generation {}, {}", hello.actor_id, hello.session, hello.generation,
            hello.isa);
  return Assignment(joined);
}

ActorRecord* Fleet::Find(int64_t session) {
  const auto it = std::find_if(actors_.begin(), actors_.end(), [session](const auto& entry) {
    return entry.second.joined && entry.second.session == session;
  });
  return it == actors_.end() ? nullptr : &it->second;
}

Welcome Fleet::Assignment(const ActorRecord& actor) const {
  Welcome welcome;
  welcome.incarnation = incarnation_;
  welcome.session = actor.session;
  welcome.assignment = actor.assignment;
  welcome.received = actor.stream.received();
  for (size_t v = 0; v < vehicles_.size(); ++v) {
    if (vehicles_[v].owner != actor.actor_id || vehicles_[v].heir != -1) continue;
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

int Fleet::num_joined() const {
  return static_cast<int>(
      std::count_if(actors_.begin(), actors_.end(), [](const auto& entry) { return entry.second.joined; }));
}

// Vehicles that an actor has or shall have.
int Fleet::Load(int32_t actor_id) const {
  return static_cast<int>(std::count_if(vehicles_.begin(), vehicles_.end(), [actor_id](const VehicleRecord& v) {
    return (v.heir == -1 ? v.owner : v.heir) == actor_id;
  }));
}

// Of those that stay; −1: there is none.
int32_t Fleet::LeastLoadedId(int32_t except) const {
  int32_t least = -1;
  for (const auto& [id, record] : actors_) {
    if (id == except || !record.joined || record.leaving) continue;
    if (least == -1 || Load(id) < Load(least)) least = id;
  }
  return least;
}

ActorRecord* Fleet::LeastLoaded(int32_t except) {
  const int32_t id = LeastLoadedId(except);
  return id == -1 ? nullptr : &actors_.at(id);
}

bool Fleet::HasOther(int32_t actor_id) const { return LeastLoadedId(actor_id) != -1; }

void Fleet::Renumber(ActorRecord* actor, std::vector<int64_t>* changed) {
  if (std::find(changed->begin(), changed->end(), actor->session) != changed->end()) return;
  actor->assignment = ++assignment_;
  changed->push_back(actor->session);
}

void Fleet::Give(VehicleRecord* vehicle, ActorRecord* actor, std::vector<int64_t>* changed) {
  vehicle->owner = actor->actor_id;
  vehicle->heir = -1;
  EndOpenEpisode(vehicle);
  Renumber(actor, changed);
}

std::vector<int64_t> Fleet::Start() {
  started_ = true;
  std::erase_if(actors_, [](const auto& entry) { return !entry.second.joined; });
  std::vector<int64_t> changed;
  for (VehicleRecord& vehicle : vehicles_) {
    if (actors_.contains(vehicle.owner)) continue;
    vehicle.owner = -1;
    // With everybody leaving it waits for whoever joins next.
    if (ActorRecord* actor = LeastLoaded(-1)) Give(&vehicle, actor, &changed);
  }
  return changed;
}

std::vector<int64_t> Fleet::Share(int32_t actor_id) {
  std::vector<int64_t> changed;
  for (VehicleRecord& vehicle : vehicles_) {
    if (vehicle.owner == -1) Give(&vehicle, &actors_.at(actor_id), &changed);
  }
  const int fair = static_cast<int>(vehicles_.size()) / std::max(1, num_joined());
  for (int load = Load(actor_id); load < fair; ++load) {
    auto most = actors_.end();
    for (auto it = actors_.begin(); it != actors_.end(); ++it) {
      if (it->first != actor_id && (most == actors_.end() || Load(it->first) > Load(most->first))) most = it;
    }
    if (most == actors_.end() || Load(most->first) <= load + 1) break;
    const int32_t giver = most->first;
    const auto vehicle = std::find_if(vehicles_.rbegin(), vehicles_.rend(),
                                      [giver](const VehicleRecord& v) { return v.owner == giver && v.heir == -1; });
    if (vehicle == vehicles_.rend()) break;
    vehicle->heir = actor_id;
    Renumber(&most->second, &changed);
  }
  return changed;
}

std::vector<int64_t> Fleet::Leave(int32_t actor_id) {
  std::vector<int64_t> changed;
  ActorRecord& leaver = actors_.at(actor_id);
  leaver.leaving = true;
  for (VehicleRecord& vehicle : vehicles_) {
    if (vehicle.owner != actor_id || vehicle.heir != -1) continue;
    const ActorRecord* heir = LeastLoaded(actor_id);
    if (heir == nullptr) break;
    vehicle.heir = heir->actor_id;
    disturbed_ = true;
    Renumber(&leaver, &changed);
  }
  return changed;
}

std::vector<int64_t> Fleet::Settle() {
  std::vector<int64_t> changed;
  for (VehicleRecord& vehicle : vehicles_) {
    if (vehicle.heir == -1) continue;
    const auto owner = actors_.find(vehicle.owner);
    if (owner != actors_.end() && !owner->second.settled()) continue;
    const auto heir = actors_.find(vehicle.heir);
    const bool fit = heir != actors_.end() && heir->second.joined && !heir->second.leaving;
    ActorRecord* next = fit ? &heir->second : LeastLoaded(-1);
    if (next != nullptr) Give(&vehicle, next, &changed);
  }
  return changed;
}

std::vector<int64_t> Fleet::Reassign(int32_t actor_id) {
  std::vector<int64_t> changed;
  if (!HasOther(actor_id)) return changed;
  actors_.erase(actor_id);
  disturbed_ = true;
  for (VehicleRecord& vehicle : vehicles_) {
    if (vehicle.owner == actor_id) Give(&vehicle, LeastLoaded(actor_id), &changed);
  }
  return changed;
}

bool Fleet::Gone(const ActorRecord& actor) const {
  return actor.leaving && actor.settled() &&
         std::none_of(vehicles_.begin(), vehicles_.end(),
                      [&actor](const VehicleRecord& v) { return v.owner == actor.actor_id; });
}

}  // namespace cairn::learner
