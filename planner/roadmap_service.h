#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "common/bus/bus.h"
#include "common/bus/lru_map.h"
#include "common/config/experiment.h"
#include "common/roadmap/world_goal.h"
#include "planner/world_planner.h"

namespace cairn::planner {

/// The planner process's service: owns the worlds' roadmaps, computes the cost table of any goal that is asked for,
/// answers requests on the tables plane, tells people about itself once a second. One thread.
class RoadmapService {
 public:
  /// Builds the roadmap of the experiment's own world; throws UsageError as BuildRoadmap and ComputeCostTable do.
  RoadmapService(Bus* bus, uint64_t experiment_hash, const Experiment& experiment);

  /// Serves until `stop_requested` says so (asked at least every 50 ms). While nobody asks it builds the roadmaps of
  /// worlds to come.
  void Run(const std::function<bool()>& stop_requested);

 private:
  // A table that may be asked for again.
  struct Kept {
    TableInfo info;
    Bytes blob;
  };
  void OnRequest(const TableRequest& request);
  void OnGoal(const TableRequest& request);
  const Kept& TableOf(const WorldGoal& goal);
  Kept MakeTable(const WorldGoal& goal);
  TableInfo Describe(const PlannedSite& site, const CostTable& table, const Bytes& blob);
  void SendChunks(uint64_t hash, const Bytes& blob, int32_t first, int32_t count);
  void SendTelemetry(TimePoint now);

  using Chunk = std::pair<uint64_t, int32_t>;
  struct ChunkHash {
    size_t operator()(const Chunk& chunk) const { return chunk.first + static_cast<size_t>(chunk.second); }
  };

  Bus* bus_;
  uint64_t experiment_hash_;
  WorldPlanner planner_;
  TableInfo info_;
  std::map<uint64_t, Bytes> blobs_;  // of roadmaps and the own table, by content hash
  LruMap<WorldGoal, Kept, WorldGoalHash> tables_;
  LruMap<Chunk, TimePoint, ChunkHash> sent_at_;
  PlannerTelemetry telemetry_;
  TimePoint last_telemetry_{};
};

}  // namespace cairn::planner
