#include "common/bus/codec.h"

#include <algorithm>
#include <cairn_lcm/actor_status_t.hpp>
#include <cairn_lcm/actor_telemetry_t.hpp>
#include <cairn_lcm/control_t.hpp>
#include <cairn_lcm/echo_t.hpp>
#include <cairn_lcm/experience_t.hpp>
#include <cairn_lcm/hello_t.hpp>
#include <cairn_lcm/learner_telemetry_t.hpp>
#include <cairn_lcm/planner_telemetry_t.hpp>
#include <cairn_lcm/policy_chunk_t.hpp>
#include <cairn_lcm/table_chunk_t.hpp>
#include <cairn_lcm/table_info_t.hpp>
#include <cairn_lcm/table_request_t.hpp>
#include <cairn_lcm/welcome_t.hpp>
#include <cstring>

#include "common/bus/size_walker.h"
#include "common/core/check.h"
#include "common/core/clock.h"

namespace cairn {
namespace {

constexpr int32_t kMaxFloatsPerStep = 65536;  // observation size bound: keeps products far from overflow

template <typename Type>
Bytes EncodeType(const Type& type) {
  Bytes bytes(static_cast<size_t>(type.getEncodedSize()));
  const int written = type.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  CAIRN_CHECK(written == static_cast<int>(bytes.size()), "encoded {} of {} bytes", written, bytes.size());
  return bytes;
}

// The walker has already proved that the counts fit the bytes; what is left for decode to refuse is the fingerprint.
template <typename Type>
std::optional<Type> DecodeType(ByteSpan bytes, bool sizes_agree) {
  Type type;
  if (!sizes_agree) return std::nullopt;
  if (type.decode(bytes.data(), 0, static_cast<int>(bytes.size())) != static_cast<int>(bytes.size())) {
    return std::nullopt;
  }
  return type;
}

template <typename To, typename From>
std::vector<To> Column(const std::vector<From>& rows, To (*get)(const From&)) {
  std::vector<To> column;
  column.reserve(rows.size());
  for (const From& row : rows) column.push_back(get(row));
  return column;
}

int64_t Signed(uint64_t hash) { return static_cast<int64_t>(hash); }
uint64_t Unsigned(int64_t hash) { return static_cast<uint64_t>(hash); }

bool ValidEnd(int8_t end) { return end >= 0 && end <= static_cast<int8_t>(SegmentEnd::kCut); }
bool ValidSet(int8_t set) { return set >= 0 && set <= static_cast<int8_t>(StartSet::kTest); }
bool ValidOutcome(int8_t outcome) { return outcome >= 0 && outcome <= static_cast<int8_t>(Outcome::kDiverged); }

}  // namespace

// --- small ones ------------------------------------------------------------------------------------------------------

Bytes Encode(const Echo& m) {
  cairn_lcm::echo_t t;
  t.utime = WallUs();
  t.nonce = m.nonce;
  t.size = m.size;
  t.payload.assign(static_cast<size_t>(m.size), 0);
  return EncodeType(t);
}

template <>
std::optional<Echo> Decode<Echo>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 16);
  walker.Array(walker.Count(), 1);
  const auto t = DecodeType<cairn_lcm::echo_t>(bytes, walker.Done());
  if (!t) return std::nullopt;
  return Echo{t->nonce, t->size};
}

Bytes Encode(const Hello& m) {
  cairn_lcm::hello_t t;
  t.utime = WallUs();
  t.session = m.session;
  t.experiment_hash = Signed(m.experiment_hash);
  t.protocol = m.protocol;
  t.actor_id = m.actor_id;
  t.generation = m.generation;
  t.num_vehicles = m.num_vehicles;
  t.observation_size = m.observation_size;
  t.git_revision = m.git_revision;
  t.isa = m.isa;
  return EncodeType(t);
}

template <>
std::optional<Hello> Decode<Hello>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 3 * 8 + 5 * 4);
  walker.String();
  walker.String();
  const auto t = DecodeType<cairn_lcm::hello_t>(bytes, walker.Done());
  if (!t || t->actor_id < 0 || t->generation < 0 || t->num_vehicles < 0) return std::nullopt;
  return Hello{t->session,      Unsigned(t->experiment_hash), t->protocol,     t->actor_id, t->generation,
               t->num_vehicles, t->observation_size,          t->git_revision, t->isa};
}

Bytes Encode(const Welcome& m) {
  cairn_lcm::welcome_t t;
  t.utime = WallUs();
  t.incarnation = m.incarnation;
  t.session = m.session;
  t.assignment = m.assignment;
  t.round = m.round;
  t.status = static_cast<int8_t>(m.status);
  t.num_vehicles = static_cast<int32_t>(m.vehicle.size());
  t.vehicle = m.vehicle;
  t.next_episode = m.next_episode;
  t.round_steps_done = m.round_steps_done;
  t.reason = m.reason;
  return EncodeType(t);
}

template <>
std::optional<Welcome> Decode<Welcome>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 5 * 8 + 1);
  const size_t n = walker.Count();
  walker.Array(3 * n, 4);
  walker.String();
  auto t = DecodeType<cairn_lcm::welcome_t>(bytes, walker.Done());
  if (!t || t->status < 0 || t->status > 2) return std::nullopt;
  return Welcome{t->incarnation, t->session,      t->assignment,       t->round, Welcome::Status{t->status},
                 t->vehicle,     t->next_episode, t->round_steps_done, t->reason};
}

Bytes Encode(const ActorStatus& m) {
  cairn_lcm::actor_status_t t;
  t.utime = WallUs();
  t.session = m.session;
  t.assignment = m.assignment;
  t.round = m.round;
  t.policy_version = m.policy_version;
  t.wanted_policy_version = m.wanted_policy_version;
  t.last_sequence = m.last_sequence;
  t.actor_id = m.actor_id;
  return EncodeType(t);
}

template <>
std::optional<ActorStatus> Decode<ActorStatus>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 7 * 8 + 4);
  const auto t = DecodeType<cairn_lcm::actor_status_t>(bytes, walker.Done());
  if (!t) return std::nullopt;
  return ActorStatus{t->session,       t->assignment, t->round, t->policy_version, t->wanted_policy_version,
                     t->last_sequence, t->actor_id};
}

// --- experience ------------------------------------------------------------------------------------------------------

namespace {

void EncodeSegments(const Experience& m, cairn_lcm::experience_t* t) {
  t->num_segments = static_cast<int32_t>(m.segments.size());
  size_t num_data = 0;
  for (const Segment& s : m.segments) {
    const auto n = static_cast<size_t>(s.num_steps());
    CAIRN_CHECK(n > 0 && s.observations.size() == (n + 1) * static_cast<size_t>(m.observation_size) &&
                    s.actions.size() == n * static_cast<size_t>(m.action_size),
                "segment of {} steps has {} observation floats", n, s.observations.size());
    t->vehicle.push_back(s.vehicle);
    t->episode.push_back(s.episode);
    t->first_step.push_back(s.first_step);
    t->num_steps.push_back(s.num_steps());
    t->end.push_back(static_cast<int8_t>(s.end));
    t->table_hash.push_back(Signed(s.table_hash));
    t->policy_version.push_back(s.policy_version);
    num_data += s.observations.size() + s.actions.size() + s.rewards.size();
  }
  t->data.reserve(num_data);
  for (const Segment& s : m.segments) {
    t->data.insert(t->data.end(), s.observations.begin(), s.observations.end());
    t->data.insert(t->data.end(), s.actions.begin(), s.actions.end());
    t->data.insert(t->data.end(), s.rewards.begin(), s.rewards.end());
  }
  t->num_data = static_cast<int32_t>(t->data.size());
}

void EncodeEpisodes(const std::vector<EpisodeResult>& episodes, cairn_lcm::experience_t* t) {
  t->num_episodes = static_cast<int32_t>(episodes.size());
  for (const EpisodeResult& e : episodes) {
    t->result_set.push_back(static_cast<int8_t>(e.set));
    t->result_outcome.push_back(static_cast<int8_t>(e.outcome));
    t->result_vehicle.push_back(e.vehicle);
    t->result_episode.push_back(e.episode);
    t->result_steps.push_back(e.steps);
    t->result_policy_version.push_back(e.policy_version);
    t->result_return.push_back(e.episode_return);
    t->result_duration.push_back(e.duration);
    t->result_path_length.push_back(e.path_length);
    t->result_shortest.push_back(e.shortest_length);
    t->result_clearance.push_back(e.min_clearance);
    t->result_jerk.push_back(e.mean_jerk);
  }
}

bool DecodeSegments(const cairn_lcm::experience_t& t, Experience* m) {
  const auto observation = static_cast<size_t>(t.observation_size);
  const auto action = static_cast<size_t>(t.action_size);
  size_t at = 0;
  m->segments.resize(static_cast<size_t>(t.num_segments));
  for (size_t i = 0; i < m->segments.size(); ++i) {
    const auto n = static_cast<size_t>(std::max(t.num_steps[i], 0));
    if (n == 0 || n > t.data.size() || !ValidEnd(t.end[i])) return false;
    const size_t floats = (n + 1) * observation + n * action + n;
    if (floats > t.data.size() - at) return false;
    Segment& s = m->segments[i];
    s.vehicle = t.vehicle[i];
    s.episode = t.episode[i];
    s.first_step = t.first_step[i];
    s.end = SegmentEnd{t.end[i]};
    s.table_hash = Unsigned(t.table_hash[i]);
    s.policy_incarnation = t.policy_incarnation;
    s.policy_version = t.policy_version[i];
    const float* p = t.data.data() + at;
    s.observations.assign(p, p + (n + 1) * observation);
    p += (n + 1) * observation;
    s.actions.assign(p, p + n * action);
    p += n * action;
    s.rewards.assign(p, p + n);
    at += floats;
  }
  return at == t.data.size();
}

bool DecodeEpisodes(const cairn_lcm::experience_t& t, Experience* m) {
  m->episodes.resize(static_cast<size_t>(t.num_episodes));
  for (size_t i = 0; i < m->episodes.size(); ++i) {
    if (!ValidSet(t.result_set[i]) || !ValidOutcome(t.result_outcome[i])) return false;
    m->episodes[i] = EpisodeResult{.set = StartSet{t.result_set[i]},
                                   .vehicle = t.result_vehicle[i],
                                   .episode = t.result_episode[i],
                                   .steps = t.result_steps[i],
                                   .outcome = Outcome{t.result_outcome[i]},
                                   .policy_version = t.result_policy_version[i],
                                   .episode_return = t.result_return[i],
                                   .duration = t.result_duration[i],
                                   .path_length = t.result_path_length[i],
                                   .shortest_length = t.result_shortest[i],
                                   .min_clearance = t.result_clearance[i],
                                   .mean_jerk = t.result_jerk[i]};
  }
  return true;
}

}  // namespace

Bytes Encode(const Experience& m) {
  cairn_lcm::experience_t t;
  t.utime = m.utime;
  t.session = m.session;
  t.sequence = m.sequence;
  t.policy_incarnation = m.policy_incarnation;
  t.actor_id = m.actor_id;
  t.observation_size = m.observation_size;
  t.action_size = m.action_size;
  EncodeSegments(m, &t);
  EncodeEpisodes(m.episodes, &t);
  return EncodeType(t);
}

template <>
std::optional<Experience> Decode<Experience>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 4 * 8 + 3 * 4);
  const size_t segments = walker.Count();
  const size_t episodes = walker.Count();
  const size_t data = walker.Count();
  walker.Array(segments, 4 * 4 + 1 + 2 * 8);
  walker.Array(episodes, 2 * 1 + 3 * 4 + 8 + 6 * 4);
  walker.Array(data, 4);
  const auto t = DecodeType<cairn_lcm::experience_t>(bytes, walker.Done());
  if (!t || t->observation_size < 1 || t->observation_size > kMaxFloatsPerStep) return std::nullopt;
  if (t->action_size < 1 || t->action_size > kMaxFloatsPerStep || t->sequence < 1) return std::nullopt;
  Experience m;
  m.utime = t->utime;
  m.session = t->session;
  m.sequence = t->sequence;
  m.policy_incarnation = t->policy_incarnation;
  m.actor_id = t->actor_id;
  m.observation_size = t->observation_size;
  m.action_size = t->action_size;
  if (!DecodeSegments(*t, &m) || !DecodeEpisodes(*t, &m)) return std::nullopt;
  return m;
}

// --- control ---------------------------------------------------------------------------------------------------------

Bytes Encode(const Control& m) {
  using Actor = Control::Actor;
  cairn_lcm::control_t t;
  t.utime = m.utime != 0 ? m.utime : WallUs();
  t.incarnation = m.incarnation;
  t.roadmap_hash = Signed(m.roadmap_hash);
  t.table_hash = Signed(m.table_hash);
  t.phase = static_cast<int8_t>(m.phase);
  t.lockstep = m.lockstep ? 1 : 0;
  t.warm_up = m.warm_up ? 1 : 0;
  t.round = m.round;
  t.round_steps = m.round_steps;
  t.round_extra = m.round_extra;
  t.policy_version = m.policy_version;
  t.evaluation_id = m.evaluation_id;
  t.evaluation_version = m.evaluation_version;
  t.evaluation_set = static_cast<int8_t>(m.evaluation_set);
  t.num_actors = static_cast<int32_t>(m.actors.size());
  t.actor_id = Column<int32_t, Actor>(m.actors, [](const Actor& a) { return a.actor_id; });
  t.session = Column<int64_t, Actor>(m.actors, [](const Actor& a) { return a.session; });
  t.received = Column<int64_t, Actor>(m.actors, [](const Actor& a) { return a.received; });
  t.durable = Column<int64_t, Actor>(m.actors, [](const Actor& a) { return a.durable; });
  t.credit = Column<int64_t, Actor>(m.actors, [](const Actor& a) { return a.credit; });
  t.window = Column<int64_t, Actor>(m.actors, [](const Actor& a) { return a.window; });
  t.echo_utime = Column<int64_t, Actor>(m.actors, [](const Actor& a) { return a.echo_utime; });
  t.evaluation_first = Column<int32_t, Actor>(m.actors, [](const Actor& a) { return a.evaluation_first; });
  t.evaluation_count = Column<int32_t, Actor>(m.actors, [](const Actor& a) { return a.evaluation_count; });
  return EncodeType(t);
}

template <>
std::optional<Control> Decode<Control>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 4 * 8 + 3 + 8 + 2 * 4 + 3 * 8 + 1);
  walker.Array(walker.Count(), 3 * 4 + 6 * 8);
  const auto t = DecodeType<cairn_lcm::control_t>(bytes, walker.Done());
  if (!t || t->phase < 0 || t->phase > 2 || !ValidSet(t->evaluation_set)) return std::nullopt;
  if (t->round_steps < 0 || t->round_extra < 0) return std::nullopt;
  Control m;
  m.utime = t->utime;
  m.incarnation = t->incarnation;
  m.roadmap_hash = Unsigned(t->roadmap_hash);
  m.table_hash = Unsigned(t->table_hash);
  m.phase = Control::Phase{t->phase};
  m.lockstep = t->lockstep != 0;
  m.warm_up = t->warm_up != 0;
  m.round = t->round;
  m.round_steps = t->round_steps;
  m.round_extra = t->round_extra;
  m.policy_version = t->policy_version;
  m.evaluation_id = t->evaluation_id;
  m.evaluation_version = t->evaluation_version;
  m.evaluation_set = StartSet{t->evaluation_set};
  m.actors.resize(static_cast<size_t>(t->num_actors));
  for (size_t i = 0; i < m.actors.size(); ++i) {
    m.actors[i] = {t->actor_id[i], t->session[i],    t->received[i],         t->durable[i],         t->credit[i],
                   t->window[i],   t->echo_utime[i], t->evaluation_first[i], t->evaluation_count[i]};
    if (m.actors[i].evaluation_first < 0 || m.actors[i].evaluation_count < 0) return std::nullopt;
  }
  return m;
}

Bytes Encode(const PolicyChunk& m) {
  cairn_lcm::policy_chunk_t t;
  t.utime = WallUs();
  t.incarnation = m.incarnation;
  t.version = m.version;
  t.parameters_crc = m.parameters_crc;
  t.total = m.total;
  t.offset = m.offset;
  t.size = static_cast<int32_t>(m.parameters.size());
  t.parameters = m.parameters;
  return EncodeType(t);
}

template <>
std::optional<PolicyChunk> Decode<PolicyChunk>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 4 * 8 + 2 * 4);
  walker.Array(walker.Count(), 4);
  auto t = DecodeType<cairn_lcm::policy_chunk_t>(bytes, walker.Done());
  if (!t || t->offset < 0 || t->total < t->size || t->offset > t->total - t->size) return std::nullopt;
  if (t->parameters_crc < 0 || t->parameters_crc > UINT32_MAX) return std::nullopt;
  return PolicyChunk{t->incarnation, t->version, static_cast<uint32_t>(t->parameters_crc),
                     t->total,       t->offset,  std::move(t->parameters)};
}

// --- tables ----------------------------------------------------------------------------------------------------------

Bytes Encode(const TableRequest& m) {
  cairn_lcm::table_request_t t;
  t.utime = WallUs();
  t.session = m.session;
  t.experiment_hash = Signed(m.experiment_hash);
  t.hash = Signed(m.hash);
  t.first_chunk = m.first_chunk;
  t.num_chunks = m.num_chunks;
  return EncodeType(t);
}

template <>
std::optional<TableRequest> Decode<TableRequest>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 4 * 8 + 2 * 4);
  const auto t = DecodeType<cairn_lcm::table_request_t>(bytes, walker.Done());
  if (!t || t->first_chunk < 0 || t->num_chunks < 0) return std::nullopt;
  return TableRequest{t->session, Unsigned(t->experiment_hash), Unsigned(t->hash), t->first_chunk, t->num_chunks};
}

Bytes Encode(const TableInfo& m) {
  cairn_lcm::table_info_t t;
  t.utime = WallUs();
  t.experiment_hash = Signed(m.experiment_hash);
  t.roadmap_hash = Signed(m.roadmap_hash);
  t.table_hash = Signed(m.table_hash);
  t.roadmap_bytes = m.roadmap_bytes;
  t.table_bytes = m.table_bytes;
  t.num_vertices = m.num_vertices;
  t.num_edges = m.num_edges;
  t.coverage = m.coverage;
  t.max_cost = m.max_cost;
  t.build_s = m.build_s;
  return EncodeType(t);
}

template <>
std::optional<TableInfo> Decode<TableInfo>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 4 * 8 + 4 * 4 + 3 * 8);
  const auto t = DecodeType<cairn_lcm::table_info_t>(bytes, walker.Done());
  if (!t || t->roadmap_bytes < 0 || t->table_bytes < 0) return std::nullopt;
  return TableInfo{Unsigned(t->experiment_hash),
                   Unsigned(t->roadmap_hash),
                   Unsigned(t->table_hash),
                   t->roadmap_bytes,
                   t->table_bytes,
                   t->num_vertices,
                   t->num_edges,
                   t->coverage,
                   t->max_cost,
                   t->build_s};
}

Bytes Encode(const TableChunk& m) {
  cairn_lcm::table_chunk_t t;
  t.utime = WallUs();
  t.hash = Signed(m.hash);
  t.total_bytes = m.total_bytes;
  t.chunk = m.chunk;
  t.chunk_bytes = m.chunk_bytes;
  t.size = static_cast<int32_t>(m.data.size());
  t.data = m.data;
  return EncodeType(t);
}

template <>
std::optional<TableChunk> Decode<TableChunk>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 2 * 8 + 3 * 4);
  walker.Array(walker.Count(), 1);
  auto t = DecodeType<cairn_lcm::table_chunk_t>(bytes, walker.Done());
  if (!t || t->chunk < 0 || t->chunk_bytes < 1 || t->size > t->chunk_bytes) return std::nullopt;
  if (int64_t{t->chunk} * t->chunk_bytes + t->size > t->total_bytes) return std::nullopt;
  return TableChunk{Unsigned(t->hash), t->total_bytes, t->chunk, t->chunk_bytes, std::move(t->data)};
}

// --- telemetry -------------------------------------------------------------------------------------------------------

Bytes Encode(const LearnerTelemetry& m) {
  cairn_lcm::learner_telemetry_t t;
  t.utime = WallUs();
  t.env_steps = m.env_steps;
  t.total_env_steps = m.total_env_steps;
  t.eval_steps = m.eval_steps;
  t.updates = m.updates;
  t.policy_version = m.policy_version;
  t.consumption_env_steps = m.consumption_env_steps;
  t.transitions_duplicate = m.transitions_duplicate;
  t.frames_refused = m.frames_refused;
  t.num_actors = m.num_actors;
  t.replay_size = m.replay_size;
  t.consumption_solved = m.consumption_solved;
  t.env_steps_per_s = m.env_steps_per_s;
  t.updates_per_s = m.updates_per_s;
  t.success_rate = m.success_rate;
  t.training_success_rate = m.training_success_rate;
  t.episode_return = m.episode_return;
  t.critic_loss = m.critic_loss;
  t.actor_loss = m.actor_loss;
  t.alpha = m.alpha;
  t.policy_lag = m.policy_lag;
  t.wall_s = m.wall_s;
  t.phase = m.phase;
  return EncodeType(t);
}

template <>
std::optional<LearnerTelemetry> Decode<LearnerTelemetry>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 9 * 8 + 3 * 4 + 10 * 8);
  walker.String();
  const auto t = DecodeType<cairn_lcm::learner_telemetry_t>(bytes, walker.Done());
  if (!t) return std::nullopt;
  return LearnerTelemetry{.env_steps = t->env_steps,
                          .total_env_steps = t->total_env_steps,
                          .eval_steps = t->eval_steps,
                          .updates = t->updates,
                          .policy_version = t->policy_version,
                          .consumption_env_steps = t->consumption_env_steps,
                          .transitions_duplicate = t->transitions_duplicate,
                          .frames_refused = t->frames_refused,
                          .num_actors = t->num_actors,
                          .replay_size = t->replay_size,
                          .consumption_solved = t->consumption_solved,
                          .env_steps_per_s = t->env_steps_per_s,
                          .updates_per_s = t->updates_per_s,
                          .success_rate = t->success_rate,
                          .training_success_rate = t->training_success_rate,
                          .episode_return = t->episode_return,
                          .critic_loss = t->critic_loss,
                          .actor_loss = t->actor_loss,
                          .alpha = t->alpha,
                          .policy_lag = t->policy_lag,
                          .wall_s = t->wall_s,
                          .phase = t->phase};
}

Bytes Encode(const ActorTelemetry& m) {
  cairn_lcm::actor_telemetry_t t;
  t.utime = WallUs();
  t.env_steps = m.env_steps;
  t.eval_steps = m.eval_steps;
  t.episodes = m.episodes;
  t.policy_version = m.policy_version;
  t.sent_messages = m.sent_messages;
  t.resent_messages = m.resent_messages;
  t.actor_id = m.actor_id;
  t.num_vehicles = m.num_vehicles;
  t.env_steps_per_s = m.env_steps_per_s;
  t.busy = m.busy;
  std::copy(m.pose.begin(), m.pose.end(), t.pose);
  t.d_min = m.d_min;
  return EncodeType(t);
}

template <>
std::optional<ActorTelemetry> Decode<ActorTelemetry>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 7 * 8 + 2 * 4 + 2 * 8 + 4 * 4);
  const auto t = DecodeType<cairn_lcm::actor_telemetry_t>(bytes, walker.Done());
  if (!t) return std::nullopt;
  return ActorTelemetry{t->env_steps,
                        t->eval_steps,
                        t->episodes,
                        t->policy_version,
                        t->sent_messages,
                        t->resent_messages,
                        t->actor_id,
                        t->num_vehicles,
                        t->env_steps_per_s,
                        t->busy,
                        {t->pose[0], t->pose[1], t->pose[2]},
                        t->d_min};
}

Bytes Encode(const PlannerTelemetry& m) {
  cairn_lcm::planner_telemetry_t t;
  t.utime = WallUs();
  t.roadmap_hash = Signed(m.roadmap_hash);
  t.table_hash = Signed(m.table_hash);
  t.requests = m.requests;
  t.chunks_sent = m.chunks_sent;
  t.num_vertices = m.num_vertices;
  t.num_edges = m.num_edges;
  t.coverage = m.coverage;
  t.max_cost = m.max_cost;
  return EncodeType(t);
}

template <>
std::optional<PlannerTelemetry> Decode<PlannerTelemetry>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 5 * 8 + 2 * 4 + 2 * 8);
  const auto t = DecodeType<cairn_lcm::planner_telemetry_t>(bytes, walker.Done());
  if (!t) return std::nullopt;
  return PlannerTelemetry{Unsigned(t->roadmap_hash),
                          Unsigned(t->table_hash),
                          t->requests,
                          t->chunks_sent,
                          t->num_vertices,
                          t->num_edges,
                          t->coverage,
                          t->max_cost};
}

}  // namespace cairn
