#include "planner/roadmap_service.h"

#include <algorithm>

#include "common/core/log.h"
#include "common/roadmap/roadmap_blob.h"

namespace cairn::planner {
namespace {

using std::chrono::milliseconds;

// Everyone hears every chunk, so several actors that ask at once are answered once.
constexpr auto kResendGap = milliseconds(30);
// Chunks sent for one request; the rest is asked for again. Bounds a burst to a quarter of a receive buffer.
constexpr int64_t kMaxBurstBytes = 1000000;

}  // namespace

RoadmapService::RoadmapService(Bus* bus, uint64_t experiment_hash, const BuiltRoadmap& built, const CostTable& table)
    : bus_(bus), experiment_hash_(experiment_hash) {
  const Bytes positions = PackPositions(built.roadmap);
  const Bytes costs = PackTable(table);
  info_.experiment_hash = experiment_hash;
  info_.roadmap_hash = built.roadmap.Hash();
  info_.table_hash = table.Hash();
  info_.roadmap_bytes = static_cast<int32_t>(positions.size());
  info_.table_bytes = static_cast<int32_t>(costs.size());
  info_.num_vertices = built.info.vertices;
  info_.num_edges = built.info.edges;
  info_.coverage = built.info.coverage;
  info_.max_cost = table.max_cost();
  info_.build_s = built.info.build_s;
  blobs_[info_.roadmap_hash] = positions;
  blobs_[info_.table_hash] = costs;
  telemetry_ = {info_.roadmap_hash, info_.table_hash, 0, 0, info_.num_vertices, info_.num_edges,
                info_.coverage,     info_.max_cost};
}

void RoadmapService::Run(const std::function<bool()>& stop_requested) {
  bus_->Subscribe<TableRequest>(Plane::kTables, kTableRequestChannel,
                                [this](const TableRequest& request, const FrameInfo&) { OnRequest(request); });
  bus_->CheckPlanes();
  log::Info("serving roadmap {:016x} ({} vertices, {} edges) and table {:016x}", info_.roadmap_hash, info_.num_vertices,
            info_.num_edges, info_.table_hash);
  while (!stop_requested()) {
    bus_->Poll(milliseconds(50));
    SendTelemetry(Clock::now());
  }
}

void RoadmapService::OnRequest(const TableRequest& request) {
  if (request.experiment_hash != experiment_hash_) return;
  ++telemetry_.requests;
  if (request.hash == 0) {
    bus_->Publish(Plane::kTables, kTableInfoChannel, info_);
    return;
  }
  const auto blob = blobs_.find(request.hash);
  if (blob != blobs_.end()) SendChunks(request.hash, blob->second, request.first_chunk, request.num_chunks);
}

void RoadmapService::SendChunks(uint64_t hash, const Bytes& blob, int32_t first, int32_t count) {
  const int32_t chunk_bytes = MaxMessageBytes(bus_->config().ttl) - 200;
  const auto total = static_cast<int64_t>(blob.size());
  const int64_t num_chunks = (total + chunk_bytes - 1) / chunk_bytes;
  const int64_t last = std::min({num_chunks, int64_t{first} + count, first + kMaxBurstBytes / chunk_bytes});
  const TimePoint now = Clock::now();
  for (int64_t c = first; c < last; ++c) {
    TimePoint& sent = sent_at_[{hash, static_cast<int32_t>(c)}];
    if (now - sent < kResendGap) continue;
    sent = now;
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
