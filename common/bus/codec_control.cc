#include <cairn_lcm/control_t.hpp>
#include <cairn_lcm/policy_chunk_t.hpp>

#include "common/bus/codec.h"
#include "common/bus/codec_type.h"
#include "common/core/clock.h"

namespace cairn {

using codec::DecodeType;
using codec::EncodeType;
using codec::Signed;
using codec::Unsigned;
using codec::ValidSet;

namespace {

template <typename To, typename From>
std::vector<To> Column(const std::vector<From>& rows, To (*get)(const From&)) {
  std::vector<To> column;
  column.reserve(rows.size());
  for (const From& row : rows) column.push_back(get(row));
  return column;
}

}  // namespace

Bytes Encode(const Control& m) {
  using Actor = Control::Actor;
  using Round = Control::Round;
  cairn_lcm::control_t t;
  t.utime = m.utime != 0 ? m.utime : WallUs();
  t.incarnation = m.incarnation;
  t.number = m.number;
  t.roadmap_hash = Signed(m.roadmap_hash);
  t.table_hash = Signed(m.table_hash);
  t.phase = static_cast<int8_t>(m.phase);
  t.lockstep = m.lockstep ? 1 : 0;
  t.warm_up = m.warm_up ? 1 : 0;
  t.policy_version = m.policy_version;
  t.num_rounds = static_cast<int32_t>(m.rounds.size());
  t.round = Column<int64_t, Round>(m.rounds, [](const Round& r) { return r.round; });
  t.round_vehicle_steps = Column<int64_t, Round>(m.rounds, [](const Round& r) { return r.vehicle_steps; });
  t.round_extra = Column<int32_t, Round>(m.rounds, [](const Round& r) { return r.extra; });
  t.round_policy_version = Column<int64_t, Round>(m.rounds, [](const Round& r) { return r.policy_version; });
  t.round_warm_up = Column<int8_t, Round>(m.rounds, [](const Round& r) { return static_cast<int8_t>(r.warm_up); });
  t.round_save = Column<int8_t, Round>(m.rounds, [](const Round& r) { return static_cast<int8_t>(r.save); });
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
  t.echo_us = Column<int64_t, Actor>(m.actors, [](const Actor& a) { return a.echo_us; });
  t.evaluation_first = Column<int32_t, Actor>(m.actors, [](const Actor& a) { return a.evaluation_first; });
  t.evaluation_count = Column<int32_t, Actor>(m.actors, [](const Actor& a) { return a.evaluation_count; });
  for (size_t i = 0; i < m.actors.size(); ++i) {
    for (const SequenceRange& gap : m.actors[i].gaps) {
      t.gap_actor.push_back(static_cast<int32_t>(i));
      t.gap_first.push_back(gap.first);
      t.gap_last.push_back(gap.last);
    }
  }
  t.num_gaps = static_cast<int32_t>(t.gap_actor.size());
  return EncodeType(t);
}

template <>
std::optional<Control> Decode<Control>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 5 * 8 + 3 + 8);
  walker.Array(walker.Count(), 3 * 8 + 4 + 2);
  walker.Skip(2 * 8 + 1);
  walker.Array(walker.Count(), 3 * 4 + 6 * 8);
  walker.Array(walker.Count(), 4 + 2 * 8);
  const auto t = DecodeType<cairn_lcm::control_t>(bytes, walker.Done());
  if (!t || t->phase < 0 || t->phase > 2 || !ValidSet(t->evaluation_set)) return std::nullopt;
  Control m;
  m.utime = t->utime;
  m.incarnation = t->incarnation;
  m.number = t->number;
  m.roadmap_hash = Unsigned(t->roadmap_hash);
  m.table_hash = Unsigned(t->table_hash);
  m.phase = Control::Phase{t->phase};
  m.lockstep = t->lockstep != 0;
  m.warm_up = t->warm_up != 0;
  m.policy_version = t->policy_version;
  m.rounds.resize(static_cast<size_t>(t->num_rounds));
  for (size_t i = 0; i < m.rounds.size(); ++i) {
    m.rounds[i] = {t->round[i],
                   t->round_vehicle_steps[i],
                   t->round_extra[i],
                   t->round_policy_version[i],
                   t->round_warm_up[i] != 0,
                   t->round_save[i] != 0};
    if (m.rounds[i].vehicle_steps < 0 || m.rounds[i].extra < 0) return std::nullopt;
  }
  m.evaluation_id = t->evaluation_id;
  m.evaluation_version = t->evaluation_version;
  m.evaluation_set = StartSet{t->evaluation_set};
  m.actors.resize(static_cast<size_t>(t->num_actors));
  for (size_t i = 0; i < m.actors.size(); ++i) {
    m.actors[i] = {t->actor_id[i], t->session[i], t->received[i],         t->durable[i],          t->credit[i],
                   t->window[i],   t->echo_us[i], t->evaluation_first[i], t->evaluation_count[i], {}};
    if (m.actors[i].evaluation_first < 0 || m.actors[i].evaluation_count < 0) return std::nullopt;
  }
  for (size_t i = 0; i < t->gap_actor.size(); ++i) {
    const auto actor = static_cast<size_t>(t->gap_actor[i]);
    if (t->gap_actor[i] < 0 || actor >= m.actors.size()) return std::nullopt;
    if (t->gap_first[i] < 1 || t->gap_last[i] < t->gap_first[i]) return std::nullopt;
    m.actors[actor].gaps.push_back({t->gap_first[i], t->gap_last[i]});
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

}  // namespace cairn
