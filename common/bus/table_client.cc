#include "common/bus/table_client.h"

#include "common/core/log.h"
#include "common/roadmap/roadmap_blob.h"

namespace cairn {
namespace {

constexpr auto kRetry = std::chrono::milliseconds(100);
constexpr int32_t kAllChunks = 1 << 20;

}  // namespace

TableClient::TableClient(Bus* bus, uint64_t experiment_hash)
    : bus_(bus), experiment_hash_(experiment_hash), random_(static_cast<uint32_t>(bus->config().session)) {
  bus_->Subscribe<TableInfo>(Plane::kTables, kTableInfoChannel, [this](const TableInfo& info, const FrameInfo&) {
    if (info.experiment_hash == experiment_hash_ && !info.goal) info_ = info;
  });
  bus_->Subscribe<TableChunk>(Plane::kTables, kTableChunkChannel, [this](const TableChunk& chunk, const FrameInfo&) {
    if (positions_) positions_->Add(chunk);
    if (table_) table_->Add(chunk);
    next_request_ = Clock::now() + HoldOff();
  });
}

void TableClient::RequestInfo() { want_info_ = true; }

void TableClient::Want(uint64_t roadmap_hash, uint64_t table_hash) {
  if (roadmap_hash == 0 || table_hash == 0) return;
  if (!positions_ || positions_->hash() != roadmap_hash) {
    positions_.emplace(roadmap_hash);
    taken_ = false;
  }
  if (!table_ || table_->hash() != table_hash) {
    table_.emplace(table_hash);
    taken_ = false;
  }
}

std::optional<TableClient::Tables> TableClient::Take() {
  if (taken_ || !positions_ || !table_ || !positions_->complete() || !table_->complete()) return std::nullopt;
  taken_ = true;
  auto positions = UnpackPositions(positions_->bytes());
  auto table = UnpackTable(table_->bytes());
  if (!positions || !table || positions->num_vertices() != static_cast<int>(table->cost.size())) {
    log::Error("the planner's table {:016x} does not fit its roadmap {:016x}", table_->hash(), positions_->hash());
    return std::nullopt;
  }
  return Tables{std::move(*positions), std::move(*table)};
}

void TableClient::Poll(TimePoint now) {
  if (now < next_request_) return;
  next_request_ = now + HoldOff();
  if (want_info_ && !info_) Request(0, 0, 0);
  if (positions_ && !positions_->complete()) RequestMissing(*positions_);
  if (table_ && !table_->complete()) RequestMissing(*table_);
}

// Random, so that the first of many that lack the same asks for all of them.
Duration TableClient::HoldOff() {
  return std::chrono::duration_cast<Duration>(kRetry * std::uniform_real_distribution<>(0.5, 1.5)(random_));
}

void TableClient::RequestMissing(const BlobAssembler& blob) {
  const auto [first, count] = blob.FirstGap();
  Request(blob.hash(), first, count == 0 ? kAllChunks : count);
}

void TableClient::Request(uint64_t hash, int32_t first_chunk, int32_t num_chunks) {
  bus_->Publish(Plane::kTables, kTableRequestChannel,
                TableRequest{bus_->config().session, experiment_hash_, hash, first_chunk, num_chunks});
}

}  // namespace cairn
