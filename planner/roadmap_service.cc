#include "planner/roadmap_service.h"

#include <algorithm>

#include "common/core/check.h"
#include "common/core/hash.h"
#include "common/core/log.h"
#include "common/roadmap/roadmap_blob.h"

namespace cairn::planner {
namespace {

using std::chrono::milliseconds;

// Everyone hears every chunk, so several actors that ask at once are answered once.
constexpr auto kResendGap = milliseconds(30);
// Chunks sent for one request; the rest is asked for again. Bounds a burst to a quarter of a receive buffer.
constexpr int64_t kMaxBurstBytes = 1000000;
constexpr size_t kRememberedChunks = 4096;  // more than 30 ms bring

}  // namespace

RoadmapService::RoadmapService(Bus* bus, uint64_t experiment_hash, const Experiment& experiment)
    : bus_(bus),
      experiment_hash_(experiment_hash),
      planner_(experiment),
      tables_(static_cast<size_t>(experiment.planner.table_cache_mb) << 20),
      sent_at_(kRememberedChunks) {
  const PlannedSite& home = planner_.Home();
  const CostTable table = planner_.Table(experiment.world.seed, home.world.goal);
  Bytes costs = PackTable(table);
  info_ = Describe(home, table, costs);
  blobs_[info_.table_hash] = std::move(costs);
  telemetry_ = {info_.roadmap_hash, info_.table_hash, 0, 0, info_.num_vertices, info_.num_edges,
                info_.coverage,     info_.max_cost};
}

// Beside it keeps the roadmap that the table stands on.
TableInfo RoadmapService::Describe(const PlannedSite& site, const CostTable& table, const Bytes& blob) {
  Bytes& positions = blobs_[table.roadmap_hash];
  if (positions.empty()) positions = PackPositions(site.built.roadmap);
  TableInfo info;
  info.experiment_hash = experiment_hash_;
  info.roadmap_hash = table.roadmap_hash;
  info.table_hash = ContentHash(blob.data(), blob.size());
  info.roadmap_bytes = static_cast<int32_t>(positions.size());
  info.table_bytes = static_cast<int32_t>(blob.size());
  info.num_vertices = site.built.info.vertices;
  info.num_edges = site.built.info.edges;
  info.coverage = site.built.info.coverage;
  info.max_cost = table.max_cost();
  info.build_s = site.built.info.build_s;
  return info;
}

void RoadmapService::Run(const std::function<bool()>& stop_requested) {
  bus_->Subscribe<TableRequest>(Plane::kTables, kTableRequestChannel,
                                [this](const TableRequest& request, const FrameInfo&) { OnRequest(request); });
  bus_->CheckPlanes();
  log::Info("serving roadmap {:016x} ({} vertices, {} edges) and table {:016x}", info_.roadmap_hash, info_.num_vertices,
            info_.num_edges, info_.table_hash);
  bool ahead = true;
  while (!stop_requested()) {
    const bool idle = bus_->Poll(milliseconds(ahead ? 5 : 50)) == 0;
    if (idle && ahead) ahead = planner_.BuildAhead();
    SendTelemetry(Clock::now());
  }
}

void RoadmapService::OnRequest(const TableRequest& request) {
  if (request.experiment_hash != experiment_hash_) return;
  ++telemetry_.requests;
  if (request.goal) return OnGoal(request);
  if (request.hash == 0) {
    bus_->Publish(Plane::kTables, kTableInfoChannel, info_);
    return;
  }
  const auto blob = blobs_.find(request.hash);
  if (blob != blobs_.end()) SendChunks(request.hash, blob->second, request.first_chunk, request.num_chunks);
}

void RoadmapService::OnGoal(const TableRequest& request) {
  const Kept& kept = TableOf(*request.goal);
  bus_->Publish(Plane::kTables, kTableInfoChannel, kept.info);
  if (kept.info.table_hash != 0) SendChunks(kept.info.table_hash, kept.blob, request.first_chunk, request.num_chunks);
}

const RoadmapService::Kept& RoadmapService::TableOf(const WorldGoal& goal) {
  if (const Kept* kept = tables_.Find(goal)) return *kept;
  Kept kept = MakeTable(goal);
  const size_t bytes = sizeof(kept) + kept.blob.size();
  return *tables_.Insert(goal, std::move(kept), bytes);
}

// A goal that has no table is answered with hash 0.
RoadmapService::Kept RoadmapService::MakeTable(const WorldGoal& goal) {
  Kept kept;
  try {
    const CostTable table = planner_.Table(goal.world_seed, goal.box(), goal.marks);
    kept.blob = PackTable(table);
    kept.info = Describe(planner_.Site(goal.world_seed), table, kept.blob);
  } catch (const UsageError& error) {
    log::Warning("no table: {}", error.what());
    kept.info.experiment_hash = experiment_hash_;
  }
  kept.info.goal = goal;
  return kept;
}

void RoadmapService::SendChunks(uint64_t hash, const Bytes& blob, int32_t first, int32_t count) {
  const int32_t chunk_bytes = bus_->max_message_bytes() - 200;
  const auto total = static_cast<int64_t>(blob.size());
  const int64_t num_chunks = (total + chunk_bytes - 1) / chunk_bytes;
  const int64_t last = std::min({num_chunks, int64_t{first} + count, first + kMaxBurstBytes / chunk_bytes});
  const TimePoint now = Clock::now();
  for (int64_t c = first; c < last; ++c) {
    const Chunk name{hash, static_cast<int32_t>(c)};
    TimePoint* sent = sent_at_.Find(name);
    if (sent == nullptr) sent = sent_at_.Insert(name, TimePoint{});
    if (now - *sent < kResendGap) continue;
    *sent = now;
    const int64_t begin = c * chunk_bytes;
    const int64_t end = std::min(total, begin + chunk_bytes);
    TableChunk chunk;
    chunk.hash = hash;
    chunk.total_bytes = static_cast<int32_t>(total);
    chunk.chunk = static_cast<int32_t>(c);
    chunk.chunk_bytes = chunk_bytes;
    chunk.data.assign(blob.begin() + begin, blob.begin() + end);
    bus_->Publish(Plane::kTables, kTableChunkChannel, chunk);
    ++telemetry_.chunks_sent;
  }
}

void RoadmapService::SendTelemetry(TimePoint now) {
  if (now - last_telemetry_ < std::chrono::seconds(1)) return;
  last_telemetry_ = now;
  bus_->Publish(Plane::kTelemetry, kPlannerChannel, telemetry_);
}

}  // namespace cairn::planner
