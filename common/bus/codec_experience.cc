#include <algorithm>
#include <cairn_lcm/experience_t.hpp>

#include "common/bus/codec.h"
#include "common/bus/codec_type.h"
#include "common/core/check.h"
#include "common/core/clock.h"

namespace cairn {

using codec::DecodeType;
using codec::EncodeType;
using codec::Signed;
using codec::Unsigned;
using codec::ValidSet;

namespace {

constexpr int32_t kMaxFloatsPerStep = 65536;  // observation size bound: keeps products far from overflow

bool ValidEnd(int8_t end) { return end >= 0 && end <= static_cast<int8_t>(SegmentEnd::kCut); }
bool ValidOutcome(int8_t outcome) { return outcome >= 0 && outcome <= static_cast<int8_t>(Outcome::kDiverged); }

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
    t->result_filtered.push_back(e.filtered_steps);
  }
}

void EncodeStates(const std::vector<VehicleStatePiece>& states, cairn_lcm::experience_t* t) {
  t->num_states = static_cast<int32_t>(states.size());
  for (const VehicleStatePiece& piece : states) {
    t->state_vehicle.push_back(piece.vehicle);
    t->state_steps.push_back(piece.steps);
    t->state_total.push_back(piece.total);
    t->state_offset.push_back(piece.offset);
    t->state_size.push_back(static_cast<int32_t>(piece.data.size()));
    t->state_data.insert(t->state_data.end(), piece.data.begin(), piece.data.end());
  }
  t->num_state_data = static_cast<int32_t>(t->state_data.size());
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
                                   .mean_jerk = t.result_jerk[i],
                                   .filtered_steps = t.result_filtered[i]};
  }
  return true;
}

bool DecodeStates(const cairn_lcm::experience_t& t, Experience* m) {
  size_t at = 0;
  m->states.resize(static_cast<size_t>(t.num_states));
  for (size_t i = 0; i < m->states.size(); ++i) {
    const int32_t size = t.state_size[i];
    if (t.state_offset[i] < 0 || size < 0 || static_cast<size_t>(size) > t.state_data.size() - at) return false;
    const auto begin = t.state_data.begin() + static_cast<std::ptrdiff_t>(at);
    m->states[i] = {t.state_vehicle[i], t.state_steps[i], t.state_total[i], t.state_offset[i],
                    Bytes(begin, begin + size)};
    at += static_cast<size_t>(size);
  }
  return at == t.state_data.size();
}

}  // namespace

Bytes Encode(const Experience& m) {
  cairn_lcm::experience_t t;
  t.utime = WallUs();
  t.send_us = m.send_us;
  t.session = m.session;
  t.sequence = m.sequence;
  t.policy_incarnation = m.policy_incarnation;
  t.actor_id = m.actor_id;
  t.observation_size = m.observation_size;
  t.action_size = m.action_size;
  EncodeSegments(m, &t);
  EncodeEpisodes(m.episodes, &t);
  EncodeStates(m.states, &t);
  return EncodeType(t);
}

template <>
std::optional<Experience> Decode<Experience>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 5 * 8 + 3 * 4);
  const size_t segments = walker.Count();
  const size_t episodes = walker.Count();
  const size_t data = walker.Count();
  const size_t states = walker.Count();
  const size_t state_data = walker.Count();
  walker.Array(segments, 4 * 4 + 1 + 2 * 8);
  walker.Array(episodes, 2 * 1 + 4 * 4 + 8 + 6 * 4);
  walker.Array(data, 4);
  walker.Array(states, 4 * 4 + 8);
  walker.Array(state_data, 1);
  const auto t = DecodeType<cairn_lcm::experience_t>(bytes, walker.Done());
  if (!t || t->observation_size < 1 || t->observation_size > kMaxFloatsPerStep) return std::nullopt;
  if (t->action_size < 1 || t->action_size > kMaxFloatsPerStep || t->sequence < 1) return std::nullopt;
  Experience m;
  m.send_us = t->send_us;
  m.session = t->session;
  m.sequence = t->sequence;
  m.policy_incarnation = t->policy_incarnation;
  m.actor_id = t->actor_id;
  m.observation_size = t->observation_size;
  m.action_size = t->action_size;
  if (!DecodeSegments(*t, &m) || !DecodeEpisodes(*t, &m) || !DecodeStates(*t, &m)) return std::nullopt;
  return m;
}

}  // namespace cairn
