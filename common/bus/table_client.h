#pragma once

#include <memory>
#include <optional>
#include <random>

#include "common/bus/blob_assembler.h"
#include "common/bus/bus.h"
#include "common/roadmap/roadmap.h"

namespace cairn {

/// Pulls the planner's roadmap positions and cost tables by content hash. Drive it with Poll beside Bus::Poll, on the
/// thread that polls the bus; it asks again about every 100 ms until it has what it wants.
class TableClient {
 public:
  /// Subscribes to the tables plane.
  TableClient(Bus* bus, uint64_t experiment_hash);

  /// Asks what the planner has; answered in info().
  void RequestInfo();
  const std::optional<TableInfo>& info() const { return info_; }

  /// Wants these blobs from now on (0: none); nothing happens for hashes it has already.
  void Want(uint64_t roadmap_hash, uint64_t table_hash);

  /// Positions and table when both wanted blobs are complete and sound, once per Want.
  struct Tables {
    Roadmap positions;
    CostTable table;
  };
  std::optional<Tables> Take();

  /// Sends requests that are due.
  void Poll(TimePoint now);

 private:
  void Request(uint64_t hash, int32_t first_chunk, int32_t num_chunks);
  void RequestMissing(const BlobAssembler& blob);
  Duration HoldOff();

  Bus* bus_;
  uint64_t experiment_hash_;
  std::minstd_rand random_;
  bool want_info_ = false;
  std::optional<TableInfo> info_;
  std::optional<BlobAssembler> positions_;
  std::optional<BlobAssembler> table_;
  bool taken_ = true;
  TimePoint next_request_{};
};

}  // namespace cairn
