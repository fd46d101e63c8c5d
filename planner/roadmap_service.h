#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "common/bus/bus.h"
#include "common/config/experiment.h"
#include "planner/planner.h"

namespace cairn::planner {

/// The planner process's service: owns the roadmap and the goal's cost table, answers requests on the tables plane by
/// content hash, tells people about itself once a second. One thread.
class RoadmapService {
 public:
  RoadmapService(Bus* bus, uint64_t experiment_hash, const BuiltRoadmap& built, const CostTable& table);

  /// Serves until `stop_requested` says so (asked at least every 50 ms).
  void Run(const std::function<bool()>& stop_requested);

 private:
  void OnRequest(const TableRequest& request);
  void SendChunks(uint64_t hash, const Bytes& blob, int32_t first, int32_t count);
  void SendTelemetry(TimePoint now);

  Bus* bus_;
  uint64_t experiment_hash_;
  TableInfo info_;
  std::map<uint64_t, Bytes> blobs_;  // by content hash
  std::map<std::pair<uint64_t, int32_t>, TimePoint> sent_at_;
  PlannerTelemetry telemetry_;
  TimePoint last_telemetry_{};
};

}  // namespace cairn::planner
