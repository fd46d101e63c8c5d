#include "learner/checkpoint/checkpoint_file.h"

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "common/core/check.h"
#include "common/core/hash.h"
#include "learner/checkpoint/checkpoint.pb.h"

namespace cairn::learner {
namespace {

static_assert(std::endian::native == std::endian::little, "checkpoints are little-endian");

constexpr char kMagic[] = {'C', 'A', 'I', 'R', 'N', 'C', 'K', 'P'};
constexpr uint32_t kFormatVersion = 1;
constexpr size_t kHeaderBytes = sizeof(kMagic) + sizeof(uint32_t) + sizeof(uint64_t);
constexpr char kBooks[] = "books";
constexpr char kReplay[] = "replay";
constexpr char kCandidate[] = "candidate/";  // and the policy's version, "/", the array's name

template <typename T>
void Append(const T& value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <typename T>
T ReadAt(const std::string& bytes, size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

std::string ToText(const Bytes& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }
Bytes ToBytes(const std::string& text) { return {text.begin(), text.end()}; }

// --- to protobuf -----------------------------------------------------------------------------------------------------

void Put(const PolicySnapshot& policy, proto::PolicyAt* out) {
  out->set_version(policy.version);
  out->set_env_steps(policy.env_steps);
  out->set_parameters(policy.parameters.data(), policy.parameters.size() * sizeof(float));
}

void Put(const CoordinatorCounters& counters, proto::Books::Counters* out) {
  out->set_transitions_accepted(counters.transitions_accepted);
  out->set_transitions_lost(counters.transitions_lost);
  out->set_transitions_duplicate(counters.transitions_duplicate);
  out->set_stream_duplicates(counters.stream_duplicates);
  out->set_eval_steps(counters.eval_steps);
  out->set_refused(counters.refused);
  out->set_policy_lag_sum(counters.policy_lag_sum);
  out->set_policy_lag_count(counters.policy_lag_count);
  out->set_disturbed(counters.disturbed);
}

void Put(const VehicleState& vehicle, proto::Books::Vehicle* out) {
  out->set_next_episode(vehicle.next_episode);
  out->set_episode(vehicle.episode);
  out->set_next_step(vehicle.next_step);
  out->set_open(vehicle.open);
  out->set_diverged(vehicle.diverged);
  out->set_steps(vehicle.steps);
  out->set_state(ToText(vehicle.environment));
  out->set_owner(vehicle.owner);
}

void Put(const SessionState& session, proto::Books::Session* out) {
  out->set_actor_id(session.actor_id);
  out->set_session(session.session);
  out->set_generation(session.generation);
  out->set_assignment(session.assignment);
  out->set_received(session.received);
  out->set_accepted(session.accepted);
  out->set_credit(session.credit);
}

void Put(const EvaluationState& state, proto::Books::Evaluation* out) {
  out->set_next_check(state.next_check);
  out->set_num_checks(state.num_checks);
  out->set_consumption_env_steps(state.consumption_env_steps);
  out->set_consumption_wall_s(state.consumption_wall_s);
  out->set_later_checks(state.later_checks);
  out->set_later_solved(state.later_solved);
  out->set_last_solved(state.last_solved);
  out->set_failed_checks(state.failed_checks);
  if (state.best) Put(*state.best, out->mutable_best());
  out->set_best_success(state.best_success);
  out->set_best_time(state.best_time);
  out->set_collapsed(state.collapsed);
  for (const EvaluationState::Asked& asked : state.asked) {
    proto::Books::Request* request = out->add_request();
    request->set_set(static_cast<int32_t>(asked.request.set));
    request->set_num_starts(asked.request.num_starts);
    request->set_tag(asked.request.tag);
    Put(asked.policy, request->mutable_policy());
  }
}

proto::Books MakeBooks(const RunState& state) {
  proto::Books books;
  for (const auto& [name, value] : state.fields) {
    proto::Books::Field* field = books.add_field();
    field->set_name(name);
    field->set_value(value);
  }
  books.set_git_revision(state.git_revision);
  books.set_env_steps(state.env_steps);
  books.set_updates(state.updates);
  books.set_granted(state.granted);
  books.set_rounds(state.coordinator.rounds);
  books.set_transitions_rolled_back(state.transitions_rolled_back);
  books.set_wall_s(state.wall_s);
  books.set_episode_log_bytes(state.episode_log_bytes);
  for (const VehicleState& vehicle : state.coordinator.vehicles) Put(vehicle, books.add_vehicle());
  for (const RoundState& granted : state.coordinator.granted) {
    proto::Books::Round* round = books.add_round();
    round->set_steps(granted.steps);
    round->set_extra(granted.extra);
    round->set_warm_up(granted.warm_up);
    Put(granted.policy, round->mutable_policy());
  }
  for (const SessionState& session : state.coordinator.sessions) Put(session, books.add_session());
  Put(state.coordinator.counters, books.mutable_counters());
  Put(state.evaluation, books.mutable_evaluation());
  return books;
}

proto::ReplayIndex MakeReplayIndex(const ReplayIndex& index) {
  proto::ReplayIndex out;
  out.set_num_inserted(index.num_inserted);
  out.set_row_floats(index.row_floats);
  for (const ReplayChunk& chunk : index.chunks) {
    proto::ReplayIndex::Chunk* c = out.add_chunk();
    c->set_file(chunk.file);
    c->set_first(chunk.first);
    c->set_rows(chunk.rows);
    c->set_crc32c(chunk.crc32c);
  }
  return out;
}

std::string Serialize(const google::protobuf::MessageLite& message) {
  CheckCheckpointSize(message.ByteSizeLong());
  return message.SerializeAsString();
}

void AddSection(const std::string& name, std::string data, proto::Checkpoint* checkpoint) {
  proto::Checkpoint::Section* section = checkpoint->add_section();
  section->set_name(name);
  section->set_crc32c(Crc32c(data.data(), data.size()));
  section->set_data(std::move(data));
}

// --- from protobuf ---------------------------------------------------------------------------------------------------

PolicySnapshot GetPolicy(const proto::PolicyAt& in) {
  PolicySnapshot policy{in.version(), in.env_steps(), std::vector<float>(in.parameters().size() / sizeof(float))};
  std::memcpy(policy.parameters.data(), in.parameters().data(), policy.parameters.size() * sizeof(float));
  return policy;
}

CoordinatorCounters GetCounters(const proto::Books::Counters& in) {
  CoordinatorCounters counters;
  counters.transitions_accepted = in.transitions_accepted();
  counters.transitions_lost = in.transitions_lost();
  counters.transitions_duplicate = in.transitions_duplicate();
  counters.stream_duplicates = in.stream_duplicates();
  counters.eval_steps = in.eval_steps();
  counters.refused = in.refused();
  counters.policy_lag_sum = in.policy_lag_sum();
  counters.policy_lag_count = in.policy_lag_count();
  counters.disturbed = in.disturbed();
  return counters;
}

EvaluationState GetEvaluation(const proto::Books::Evaluation& in) {
  EvaluationState state;
  state.next_check = in.next_check();
  state.num_checks = in.num_checks();
  state.consumption_env_steps = in.consumption_env_steps();
  state.consumption_wall_s = in.consumption_wall_s();
  state.later_checks = in.later_checks();
  state.later_solved = in.later_solved();
  state.last_solved = in.last_solved();
  state.failed_checks = in.failed_checks();
  if (in.has_best()) state.best = GetPolicy(in.best());
  state.best_success = in.best_success();
  state.best_time = in.best_time();
  state.collapsed = in.collapsed();
  for (const proto::Books::Request& request : in.request()) {
    EvaluationState::Asked asked;
    asked.policy = GetPolicy(request.policy());
    asked.request = {asked.policy.version, static_cast<StartSet>(request.set()), request.num_starts(),
                     asked.policy.env_steps, request.tag()};
    state.asked.push_back(std::move(asked));
  }
  return state;
}

void GetBooks(const proto::Books& books, RunState* state) {
  for (const proto::Books::Field& field : books.field()) state->fields.emplace_back(field.name(), field.value());
  state->git_revision = books.git_revision();
  state->env_steps = books.env_steps();
  state->updates = books.updates();
  state->granted = books.granted();
  state->transitions_rolled_back = books.transitions_rolled_back();
  state->wall_s = books.wall_s();
  state->episode_log_bytes = books.episode_log_bytes();
  state->coordinator.rounds = books.rounds();
  for (const proto::Books::Vehicle& v : books.vehicle()) {
    state->coordinator.vehicles.push_back({v.next_episode(), v.episode(), v.next_step(), v.open(), v.diverged(),
                                           v.steps(), ToBytes(v.state()), v.owner()});
  }
  for (const proto::Books::Round& r : books.round()) {
    state->coordinator.granted.push_back({r.steps(), r.extra(), r.warm_up(), GetPolicy(r.policy())});
  }
  for (const proto::Books::Session& s : books.session()) {
    state->coordinator.sessions.push_back(
        {s.actor_id(), s.session(), s.generation(), s.assignment(), s.received(), s.accepted(), s.credit()});
  }
  state->coordinator.counters = GetCounters(books.counters());
  state->evaluation = GetEvaluation(books.evaluation());
}

void GetReplayIndex(const proto::ReplayIndex& in, ReplayIndex* index) {
  index->num_inserted = in.num_inserted();
  index->row_floats = in.row_floats();
  for (const proto::ReplayIndex::Chunk& c : in.chunk()) {
    index->chunks.push_back({c.file(), c.first(), c.rows(), c.crc32c()});
  }
}

bool GetCandidate(const proto::Checkpoint::Section& section, NetworksByVersion* candidates) {
  const std::string_view rest = std::string_view(section.name()).substr(sizeof(kCandidate) - 1);
  int64_t version = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), version);
  if (error != std::errc() || end == rest.data() + rest.size() || *end != '/') return false;
  (*candidates)[version].push_back({std::string(end + 1, rest.data() + rest.size()), ToBytes(section.data())});
  return true;
}

void GetSection(const proto::Checkpoint::Section& section, const std::string& path, RunState* state) {
  const std::string& data = section.data();
  const uint32_t crc = Crc32c(data.data(), data.size());
  if (crc != section.crc32c()) {
    ThrowError("checkpoint {}: section {} is damaged: CRC32C {:08x}, stored {:08x}", path, section.name(), crc,
               section.crc32c());
  }
  bool parsed = true;
  if (section.name() == kBooks) {
    proto::Books books;
    parsed = books.ParseFromString(data);
    GetBooks(books, state);
  } else if (section.name() == kReplay) {
    proto::ReplayIndex index;
    parsed = index.ParseFromString(data);
    GetReplayIndex(index, &state->replay);
  } else if (section.name().starts_with(kCandidate)) {
    parsed = GetCandidate(section, &state->candidates);
  } else {
    state->algorithm.push_back({section.name(), ToBytes(data)});
  }
  if (!parsed) ThrowError("checkpoint {}: section {} cannot be decoded", path, section.name());
}

}  // namespace

// protobuf's own limit: of what is larger SerializeAsString says a line on stderr and gives nothing.
void CheckCheckpointSize(size_t bytes) {
  if (bytes <= INT32_MAX) return;
  ThrowError("a checkpoint of {} bytes cannot be written: {} is the most", bytes, INT32_MAX);
}

std::string EncodeCheckpoint(const RunState& state) {
  proto::Checkpoint checkpoint;
  AddSection(kBooks, Serialize(MakeBooks(state)), &checkpoint);
  AddSection(kReplay, Serialize(MakeReplayIndex(state.replay)), &checkpoint);
  for (const auto& [version, arrays] : state.candidates) {
    const std::string prefix = kCandidate + std::to_string(version) + "/";
    for (const StateArray& array : arrays) AddSection(prefix + array.name, ToText(array.data), &checkpoint);
  }
  for (const StateArray& array : state.algorithm) AddSection(array.name, ToText(array.data), &checkpoint);
  const std::string body = Serialize(checkpoint);
  std::string bytes(kMagic, sizeof(kMagic));
  Append(kFormatVersion, &bytes);
  Append(static_cast<uint64_t>(body.size()), &bytes);
  bytes += body;
  Append(Crc32c(bytes.data(), bytes.size()), &bytes);
  return bytes;
}

RunState DecodeCheckpoint(const std::string& bytes, const std::string& path) {
  constexpr size_t kFrame = kHeaderBytes + sizeof(uint32_t);
  if (bytes.size() < kFrame || std::memcmp(bytes.data(), kMagic, sizeof(kMagic)) != 0) {
    ThrowError("checkpoint {}: cut off or not a checkpoint ({} bytes)", path, bytes.size());
  }
  const auto size = ReadAt<uint64_t>(bytes, sizeof(kMagic) + sizeof(uint32_t));
  if (size != bytes.size() - kFrame) {
    ThrowError("checkpoint {}: cut off: {} bytes, {} promised", path, bytes.size() - kFrame, size);
  }
  const uint32_t crc = Crc32c(bytes.data(), bytes.size() - sizeof(uint32_t));
  const auto stored = ReadAt<uint32_t>(bytes, bytes.size() - sizeof(uint32_t));
  const auto format = ReadAt<uint32_t>(bytes, sizeof(kMagic));
  if (format != kFormatVersion && crc == stored) {
    ThrowUsageError("checkpoint {}: format version {}, this program reads {}", path, format, kFormatVersion);
  }
  proto::Checkpoint checkpoint;
  const bool parsed = checkpoint.ParseFromArray(bytes.data() + kHeaderBytes, static_cast<int>(size));
  RunState state;
  if (parsed) {
    for (const proto::Checkpoint::Section& section : checkpoint.section()) GetSection(section, path, &state);
  }
  if (!parsed || crc != stored) ThrowError("checkpoint {}: damaged: CRC32C {:08x}, stored {:08x}", path, crc, stored);
  return state;
}

}  // namespace cairn::learner
