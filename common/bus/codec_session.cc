#include <cairn_lcm/actor_status_t.hpp>
#include <cairn_lcm/echo_t.hpp>
#include <cairn_lcm/hello_t.hpp>
#include <cairn_lcm/vehicle_state_t.hpp>
#include <cairn_lcm/welcome_t.hpp>

#include "common/bus/codec.h"
#include "common/bus/codec_type.h"
#include "common/core/clock.h"

namespace cairn {

using codec::DecodeType;
using codec::EncodeType;
using codec::Signed;
using codec::Unsigned;

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
  t.incarnation = m.incarnation;
  t.transitions = m.transitions;
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
  walker.Skip(8 + 5 * 8 + 5 * 4);
  walker.String();
  walker.String();
  const auto t = DecodeType<cairn_lcm::hello_t>(bytes, walker.Done());
  if (!t || t->actor_id < 0 || t->actor_id > kMaxActorId || t->generation < 0 || t->num_vehicles < 0 ||
      t->transitions < 0) {
    return std::nullopt;
  }
  return Hello{t->session,
               Unsigned(t->experiment_hash),
               t->incarnation,
               t->transitions,
               t->protocol,
               t->actor_id,
               t->generation,
               t->num_vehicles,
               t->observation_size,
               t->git_revision,
               t->isa};
}

Bytes Encode(const Welcome& m) {
  cairn_lcm::welcome_t t;
  t.utime = WallUs();
  t.incarnation = m.incarnation;
  t.session = m.session;
  t.assignment = m.assignment;
  t.received = m.received;
  t.status = static_cast<int8_t>(m.status);
  t.num_vehicles = static_cast<int32_t>(m.vehicle.size());
  t.vehicle = m.vehicle;
  t.next_episode = m.next_episode;
  t.steps_done = m.steps_done;
  t.state_bytes = m.state_bytes;
  t.reason = m.reason;
  return EncodeType(t);
}

template <>
std::optional<Welcome> Decode<Welcome>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 5 * 8 + 1);
  walker.Array(walker.Count(), 3 * 4 + 8);
  walker.String();
  auto t = DecodeType<cairn_lcm::welcome_t>(bytes, walker.Done());
  if (!t || t->status < 0 || t->status > 3 || t->received < 0) return std::nullopt;
  return Welcome{t->incarnation, t->session,      t->assignment, t->received,    Welcome::Status{t->status},
                 t->vehicle,     t->next_episode, t->steps_done, t->state_bytes, t->reason};
}

Bytes Encode(const AssignedState& m) {
  cairn_lcm::vehicle_state_t t;
  t.utime = WallUs();
  t.incarnation = m.incarnation;
  t.session = m.session;
  t.assignment = m.assignment;
  t.steps = m.piece.steps;
  t.vehicle = m.piece.vehicle;
  t.total = m.piece.total;
  t.offset = m.piece.offset;
  t.size = static_cast<int32_t>(m.piece.data.size());
  t.data = m.piece.data;
  return EncodeType(t);
}

template <>
std::optional<AssignedState> Decode<AssignedState>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 5 * 8 + 3 * 4);
  walker.Array(walker.Count(), 1);
  auto t = DecodeType<cairn_lcm::vehicle_state_t>(bytes, walker.Done());
  if (!t || t->vehicle < 0 || t->total < 1 || t->offset < 0 || t->size > t->total - t->offset) return std::nullopt;
  return AssignedState{
      t->incarnation, t->session, t->assignment, {t->vehicle, t->steps, t->total, t->offset, std::move(t->data)}};
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
  t.sent = m.sent;
  t.resent = m.resent;
  t.wait_us = m.wait_us;
  t.round_trip_us = m.round_trip_us;
  t.actor_id = m.actor_id;
  t.leaving = m.leaving ? 1 : 0;
  return EncodeType(t);
}

template <>
std::optional<ActorStatus> Decode<ActorStatus>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 11 * 8 + 4 + 1);
  const auto t = DecodeType<cairn_lcm::actor_status_t>(bytes, walker.Done());
  if (!t) return std::nullopt;
  return ActorStatus{.session = t->session,
                     .assignment = t->assignment,
                     .round = t->round,
                     .policy_version = t->policy_version,
                     .wanted_policy_version = t->wanted_policy_version,
                     .last_sequence = t->last_sequence,
                     .sent = t->sent,
                     .resent = t->resent,
                     .wait_us = t->wait_us,
                     .round_trip_us = t->round_trip_us,
                     .actor_id = t->actor_id,
                     .leaving = t->leaving != 0};
}

}  // namespace cairn
