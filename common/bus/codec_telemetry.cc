#include <algorithm>
#include <cairn_lcm/actor_telemetry_t.hpp>
#include <cairn_lcm/learner_telemetry_t.hpp>
#include <cairn_lcm/planner_telemetry_t.hpp>

#include "common/bus/codec.h"
#include "common/bus/codec_type.h"
#include "common/core/clock.h"

namespace cairn {

using codec::DecodeType;
using codec::EncodeType;
using codec::Signed;
using codec::Unsigned;

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
  t.messages_sent = m.messages_sent;
  t.messages_resent = m.messages_resent;
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
  t.stream_latency = m.stream_latency;
  t.credit_wait = m.credit_wait;
  t.wall_s = m.wall_s;
  t.warning = m.warning;
  t.phase = m.phase;
  return EncodeType(t);
}

template <>
std::optional<LearnerTelemetry> Decode<LearnerTelemetry>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 11 * 8 + 3 * 4 + 12 * 8);
  walker.String();
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
                          .messages_sent = t->messages_sent,
                          .messages_resent = t->messages_resent,
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
                          .stream_latency = t->stream_latency,
                          .credit_wait = t->credit_wait,
                          .wall_s = t->wall_s,
                          .warning = t->warning,
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
  walker.Skip(8 + 7 * 8 + 2 * 4 + 2 * 8 + 5 * 4);
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
                        {t->pose[0], t->pose[1], t->pose[2], t->pose[3]},
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
