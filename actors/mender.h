#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "actors/blob.h"
#include "actors/marks.h"
#include "actors/surprise_finder.h"
#include "common/config/experiment.h"

namespace cairn::actors {

/// A vehicle's part of repair: the marks that its tables are asked for with. They depend on what the vehicle itself has
/// seen, so that LOCKSTEP's results do not depend on who runs it; the planner, which makes the tables, keeps none.
class Mender {
 public:
  explicit Mender(const PlannerConfig& config);

  /// planner.repair is not NONE.
  bool active() const { return active_; }

  /// An episode begins in the world of this seed: without marks, or with planner.repair_kept with those it has there.
  void Begin(uint64_t world_seed);

  /// `elapsed` seconds of the episode later. True when the marks have changed.
  bool Report(const Findings& findings, double elapsed);

  /// [3 × number], in W [m]; at most WorldGoal::kMaxMarks, the newest.
  std::vector<float> marks() const;

  void Write(BlobWriter& blob) const;
  void Read(BlobReader& blob);

 private:
  Marks NoMarks() const { return Marks(radius_, lifetime_); }

  bool active_, kept_;
  double radius_, lifetime_;
  uint64_t world_seed_ = 0;
  std::map<uint64_t, Marks> worlds_;  // by seed
  double begun_ = 0, now_ = 0;        // on a clock that runs from episode to episode [s]
};

}  // namespace cairn::actors
