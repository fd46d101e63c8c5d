#pragma once

#include <functional>
#include <list>
#include <optional>
#include <random>
#include <unordered_map>

#include "common/bus/blob_assembler.h"
#include "common/bus/bus.h"
#include "common/roadmap/roadmap.h"

namespace cairn {

/// Pulls cost tables of any goal from the planner, several at a time. Drive it with Poll beside Bus::Poll, on the
/// thread that polls the bus; it asks again about every 100 ms until it has what it wants.
class GoalTableClient {
 public:
  /// A table that has come, with the positions of its roadmap's vertices; no costs when the planner has none for it.
  using OnTable = std::function<void(const WorldGoal&, const Roadmap& positions, CostTable)>;

  /// Subscribes to the tables plane. `on_table` is called once for each Want, within Poll.
  GoalTableClient(Bus* bus, uint64_t experiment_hash, OnTable on_table);

  /// Wants this table, if it is not on its way already.
  void Want(const WorldGoal& goal);

  bool idle() const { return wanted_.empty(); }

  /// Hands over what is complete and sends requests that are due.
  void Poll(TimePoint now);

 private:
  struct Wanted {
    WorldGoal goal;
    std::optional<TableInfo> info;
    std::optional<BlobAssembler> table;
    TimePoint next_request{};
  };

  void OnInfo(const TableInfo& info);
  void OnChunk(const TableChunk& chunk);
  bool Deliver(const Wanted& wanted);
  void Request(Wanted* wanted, TimePoint now);
  void RequestRoadmaps(TimePoint now);
  Duration HoldOff();

  Bus* bus_;
  uint64_t experiment_hash_;
  OnTable on_table_;
  std::minstd_rand random_;
  std::list<Wanted> wanted_;  // oldest first
  struct Positions {
    BlobAssembler blob;
    std::optional<Roadmap> roadmap;
    TimePoint next_request{};
  };
  std::unordered_map<uint64_t, Positions> roadmaps_;  // by hash; one for each world
};

}  // namespace cairn
