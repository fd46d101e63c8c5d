#pragma once

#include <cstddef>
#include <cstdint>

#include "common/bus/bus.h"
#include "learner/evaluation_queue.h"
#include "learner/fleet.h"

namespace cairn::learner {

/// Writes the aggregated control frame (DESIGN 9): what concerns all actors, and for each of them how far its stream
/// has come, its gaps, its credit and its share of the evaluation under way.
class ControlWriter {
 public:
  explicit ControlWriter(Bus* bus) : bus_(bus) {}

  /// Bytes that one actor may have on the way.
  int64_t Window(const Fleet& fleet) const;

  /// Publishes `control` with its actors filled in, in as many parts as the size of messages asks for; one without
  /// actors when there is none. With `keeps` actors keep what no checkpoint has.
  void Send(const EvaluationQueue& evaluations, bool keeps, Fleet* fleet, Control* control) const;

 private:
  Bus* bus_;
};

}  // namespace cairn::learner
