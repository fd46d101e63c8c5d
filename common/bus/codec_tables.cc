#include <algorithm>
#include <cairn_lcm/table_chunk_t.hpp>
#include <cairn_lcm/table_info_t.hpp>
#include <cairn_lcm/table_request_t.hpp>
#include <cmath>

#include "common/bus/codec.h"
#include "common/bus/codec_type.h"
#include "common/core/clock.h"

namespace cairn {

using codec::DecodeType;
using codec::EncodeType;
using codec::Signed;
using codec::Unsigned;

namespace {

constexpr int64_t kGoalBytes = 1 + 8 + 6 * 8;

template <typename Type>
void PutGoal(const std::optional<WorldGoal>& goal, Type* t) {
  const WorldGoal g = goal.value_or(WorldGoal{});
  t->of_goal = static_cast<int8_t>(goal.has_value());
  t->world_seed = Signed(g.world_seed);
  std::copy(g.min.begin(), g.min.end(), t->goal_min);
  std::copy(g.max.begin(), g.max.end(), t->goal_max);
  t->num_marks = static_cast<int32_t>(g.marks.size());
  t->marks = g.marks;
}

template <typename Type>
bool GoalSound(const Type& t) {
  if (t.of_goal == 0) return true;
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(t.goal_min[k]) || !std::isfinite(t.goal_max[k]) || t.goal_min[k] > t.goal_max[k]) return false;
  }
  const bool finite = std::all_of(t.marks.begin(), t.marks.end(), [](float p) { return std::isfinite(p); });
  return finite && t.marks.size() % 3 == 0 && t.marks.size() <= 3 * WorldGoal::kMaxMarks && t.of_goal == 1;
}

template <typename Type>
std::optional<WorldGoal> GetGoal(const Type& t) {
  if (t.of_goal == 0) return std::nullopt;
  WorldGoal goal;
  goal.world_seed = Unsigned(t.world_seed);
  std::copy(t.goal_min, t.goal_min + 3, goal.min.begin());
  std::copy(t.goal_max, t.goal_max + 3, goal.max.begin());
  goal.marks = t.marks;
  return goal;
}

}  // namespace

Bytes Encode(const TableRequest& m) {
  cairn_lcm::table_request_t t;
  t.utime = WallUs();
  t.session = m.session;
  t.experiment_hash = Signed(m.experiment_hash);
  t.hash = Signed(m.hash);
  t.first_chunk = m.first_chunk;
  t.num_chunks = m.num_chunks;
  PutGoal(m.goal, &t);
  return EncodeType(t);
}

template <>
std::optional<TableRequest> Decode<TableRequest>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 4 * 8 + 2 * 4 + kGoalBytes);
  walker.Array(walker.Count(), 4);
  const auto t = DecodeType<cairn_lcm::table_request_t>(bytes, walker.Done());
  if (!t || t->first_chunk < 0 || t->num_chunks < 0 || !GoalSound(*t)) return std::nullopt;
  return TableRequest{t->session, Unsigned(t->experiment_hash), Unsigned(t->hash), t->first_chunk, t->num_chunks,
                      GetGoal(*t)};
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
  PutGoal(m.goal, &t);
  return EncodeType(t);
}

template <>
std::optional<TableInfo> Decode<TableInfo>(ByteSpan bytes) {
  SizeWalker walker(bytes);
  walker.Skip(8 + 4 * 8 + 4 * 4 + 3 * 8 + kGoalBytes);
  walker.Array(walker.Count(), 4);
  const auto t = DecodeType<cairn_lcm::table_info_t>(bytes, walker.Done());
  if (!t || t->roadmap_bytes < 0 || t->table_bytes < 0 || !GoalSound(*t)) return std::nullopt;
  return TableInfo{Unsigned(t->experiment_hash),
                   Unsigned(t->roadmap_hash),
                   Unsigned(t->table_hash),
                   t->roadmap_bytes,
                   t->table_bytes,
                   t->num_vertices,
                   t->num_edges,
                   t->coverage,
                   t->max_cost,
                   t->build_s,
                   GetGoal(*t)};
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

}  // namespace cairn
