#pragma once

#include <vector>

#include "common/bus/state_assembler.h"
#include "common/config/experiment.h"
#include "learner/coordinator_state.h"
#include "learner/evaluation_queue.h"
#include "learner/fleet.h"
#include "learner/harvest.h"
#include "learner/open_rounds.h"

namespace cairn::learner {

/// Judges what the actors' experience messages bring and sorts it: segments and training episodes to the open rounds
/// (LOCKSTEP) or the harvest (ASYNC), evaluated episodes to the evaluation under way, vehicles' states to the rounds
/// that asked for them. Not thread-safe; everything passed in must outlive it.
class Intake {
 public:
  /// `control` tells what is in force.
  Intake(const Experiment& experiment, const Control& control, Fleet* fleet, OpenRounds* rounds,
         EvaluationQueue* evaluations, CoordinatorCounters* counters);

  /// Takes in the next message of this actor's stream.
  void Accept(ActorRecord* actor, Experience experience);

  /// ASYNC: what was not taken yet.
  Harvest& harvest() { return harvest_; }

 private:
  bool InForce(const Segment& segment) const;
  void AcceptSegment(ActorRecord* actor, Segment segment);
  void AcceptEpisodes(const ActorRecord& actor, const Experience& experience);
  void AcceptStates(const ActorRecord& actor, const Experience& experience);
  void Refuse(const ActorRecord& actor, const Segment& segment);

  const Experiment& experiment_;
  const Control& control_;
  Fleet* fleet_;
  OpenRounds* rounds_;
  EvaluationQueue* evaluations_;
  CoordinatorCounters* counters_;
  StateAssembler states_;  // of vehicles at the end of a round that asked for them
  Harvest harvest_;
};

}  // namespace cairn::learner
