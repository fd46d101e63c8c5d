#include "common/bus/goal_table_client.h"

#include <algorithm>

#include "common/core/log.h"
#include "common/roadmap/roadmap_blob.h"

namespace cairn {
namespace {

constexpr auto kRetry = std::chrono::milliseconds(100);
constexpr int32_t kAllChunks = 1 << 20;
// Asked for at the same time; the others wait. Bounds what is on the way to a part of a receive buffer.
constexpr int kInFlight = 8;

}  // namespace

GoalTableClient::GoalTableClient(Bus* bus, uint64_t experiment_hash, OnTable on_table)
    : bus_(bus),
      experiment_hash_(experiment_hash),
      on_table_(std::move(on_table)),
      random_(static_cast<uint32_t>(bus->config().session)) {
  bus_->Subscribe<TableInfo>(Plane::kTables, kTableInfoChannel,
                             [this](const TableInfo& info, const FrameInfo&) { OnInfo(info); });
  bus_->Subscribe<TableChunk>(Plane::kTables, kTableChunkChannel,
                              [this](const TableChunk& chunk, const FrameInfo&) { OnChunk(chunk); });
}

void GoalTableClient::Want(const WorldGoal& goal) {
  const auto same = [&](const Wanted& wanted) { return wanted.goal == goal; };
  if (std::none_of(wanted_.begin(), wanted_.end(), same)) wanted_.push_back({goal, {}, {}, {}});
}

void GoalTableClient::OnInfo(const TableInfo& info) {
  if (info.experiment_hash != experiment_hash_ || !info.goal) return;
  for (Wanted& wanted : wanted_) {
    if (!(wanted.goal == *info.goal)) continue;
    wanted.info = info;
    if (info.table_hash == 0) continue;
    if (!wanted.table || wanted.table->hash() != info.table_hash) wanted.table.emplace(info.table_hash);
    roadmaps_.try_emplace(info.roadmap_hash, Positions{BlobAssembler(info.roadmap_hash), {}, {}});
  }
}

void GoalTableClient::OnChunk(const TableChunk& chunk) {
  const TimePoint next = Clock::now() + HoldOff();
  for (Wanted& wanted : wanted_) {
    if (!wanted.table || wanted.table->hash() != chunk.hash) continue;
    wanted.table->Add(chunk);
    wanted.next_request = next;
  }
  const auto roadmap = roadmaps_.find(chunk.hash);
  if (roadmap == roadmaps_.end()) return;
  roadmap->second.blob.Add(chunk);
  roadmap->second.next_request = next;
}

// True when it is done with.
bool GoalTableClient::Deliver(const Wanted& wanted) {
  if (!wanted.info) return false;
  if (wanted.info->table_hash == 0) {
    on_table_(wanted.goal, Roadmap{}, CostTable{});
    return true;
  }
  Positions& positions = roadmaps_.at(wanted.info->roadmap_hash);
  if (!wanted.table->complete() || !positions.blob.complete()) return false;
  if (!positions.roadmap) positions.roadmap = UnpackPositions(positions.blob.bytes());
  std::optional<CostTable> table = UnpackTable(wanted.table->bytes());
  if (!positions.roadmap || !table || positions.roadmap->num_vertices() != static_cast<int>(table->cost.size())) {
    log::Error("the planner's table {:016x} does not fit its roadmap {:016x}", wanted.info->table_hash,
               wanted.info->roadmap_hash);
    on_table_(wanted.goal, Roadmap{}, CostTable{});
    return true;
  }
  on_table_(wanted.goal, *positions.roadmap, std::move(*table));
  return true;
}

void GoalTableClient::Poll(TimePoint now) {
  wanted_.remove_if([this](const Wanted& wanted) { return Deliver(wanted); });
  int in_flight = 0;
  for (Wanted& wanted : wanted_) {
    if (++in_flight > kInFlight) break;
    if (now >= wanted.next_request) Request(&wanted, now);
  }
  RequestRoadmaps(now);
}

// By the goal and not by its hash: the planner may have forgotten the table meanwhile, and makes it again.
void GoalTableClient::Request(Wanted* wanted, TimePoint now) {
  wanted->next_request = now + HoldOff();
  if (wanted->table && wanted->table->complete()) return;
  const auto [first, count] = wanted->table ? wanted->table->FirstGap() : std::pair<int32_t, int32_t>{0, 0};
  bus_->Publish(
      Plane::kTables, kTableRequestChannel,
      TableRequest{bus_->config().session, experiment_hash_, 0, first, count == 0 ? kAllChunks : count, wanted->goal});
}

void GoalTableClient::RequestRoadmaps(TimePoint now) {
  for (auto& [hash, positions] : roadmaps_) {
    if (positions.blob.complete() || now < positions.next_request) continue;
    positions.next_request = now + HoldOff();
    const auto [first, count] = positions.blob.FirstGap();
    bus_->Publish(Plane::kTables, kTableRequestChannel,
                  TableRequest{bus_->config().session, experiment_hash_, hash, first, count == 0 ? kAllChunks : count,
                               std::nullopt});
  }
}

// Random, so that the first of many that lack the same asks for all of them.
Duration GoalTableClient::HoldOff() {
  return std::chrono::duration_cast<Duration>(kRetry * std::uniform_real_distribution<>(0.5, 1.5)(random_));
}

}  // namespace cairn
