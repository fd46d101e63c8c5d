#include "learner/intake.h"

#include <algorithm>
#include <utility>

#include "common/core/log.h"

namespace cairn::learner {

Intake::Intake(const Experiment& experiment, const Control& control, Fleet* fleet, OpenRounds* rounds,
               EvaluationQueue* evaluations, CoordinatorCounters* counters)
    : experiment_(experiment),
      control_(control),
      fleet_(fleet),
      rounds_(rounds),
      evaluations_(evaluations),
      counters_(counters) {}

void Intake::Accept(ActorRecord* actor, Experience experience) {
  AcceptEpisodes(*actor, experience);
  AcceptStates(*actor, experience);
  for (Segment& segment : experience.segments) AcceptSegment(actor, std::move(segment));
}

// An ASYNC learner that was restarted also takes what its predecessor's policies made.
bool Intake::InForce(const Segment& segment) const {
  const bool incarnation = control_.lockstep ? segment.policy_incarnation == control_.incarnation
                                             : segment.policy_incarnation <= control_.incarnation;
  // Each goal and each set of marks has a table of its own.
  const bool many_tables =
      experiment_.goals == Goals::kAny || experiment_.planner.repair != PlannerConfig::Repair::kNone;
  return incarnation && (many_tables ? segment.table_hash != 0 : segment.table_hash == control_.table_hash);
}

void Intake::AcceptSegment(ActorRecord* actor, Segment segment) {
  switch (fleet_->Judge(*actor, segment)) {
    case Fleet::Verdict::kSound:
      break;
    case Fleet::Verdict::kDuplicate:
      counters_->transitions_duplicate += segment.num_steps();
      return;
    case Fleet::Verdict::kGap:
      counters_->transitions_lost += segment.num_steps();
      log::Error("actor {}: vehicle {} episode {} step {} does not continue what was received", actor->actor_id,
                 segment.vehicle, segment.episode, segment.first_step);
      return;
    case Fleet::Verdict::kForeign:
    case Fleet::Verdict::kNotFinite:
      ++counters_->refused;
      return;
  }
  if (!InForce(segment)) return Refuse(*actor, segment);
  const VehicleRecord& vehicle = fleet_->vehicles()[static_cast<size_t>(segment.vehicle)];
  if (control_.lockstep && !rounds_->Add(segment, vehicle.steps)) return Refuse(*actor, segment);
  fleet_->Accept(segment);
  if (control_.lockstep) {
    VehicleState passed = vehicle;
    if (const Bytes* state = states_.Find(segment.vehicle, passed.steps)) passed.environment = *state;
    rounds_->Passed(segment.vehicle, passed);
  }
  actor->accepted += segment.num_steps();
  counters_->transitions_accepted += segment.num_steps();
  if (segment.policy_incarnation == control_.incarnation) {
    counters_->policy_lag_sum +=
        static_cast<double>(std::max<int64_t>(0, control_.policy_version - segment.policy_version));
    ++counters_->policy_lag_count;
  } else {
    counters_->recovered += segment.num_steps();
  }
  if (!control_.lockstep) harvest_.segments.push_back(std::move(segment));
}

void Intake::AcceptStates(const ActorRecord& actor, const Experience& experience) {
  for (const VehicleStatePiece& piece : experience.states) {
    const bool known = piece.vehicle >= 0 && piece.vehicle < experiment_.num_vehicles;
    if (known && fleet_->vehicles()[static_cast<size_t>(piece.vehicle)].owner == actor.actor_id) states_.Add(piece);
  }
}

void Intake::Refuse(const ActorRecord& actor, const Segment& segment) {
  ++counters_->refused;
  log::Warning(
      "actor {}: {} steps of vehicle {} refused: table {:016x}, policy {:016x} version {}; in force are table {:016x}, "
      "policy {:016x} version {}, {} steps missing in the open rounds",
      actor.actor_id, segment.num_steps(), segment.vehicle, segment.table_hash, segment.policy_incarnation,
      segment.policy_version, control_.table_hash, control_.incarnation, control_.policy_version, rounds_->missing());
}

void Intake::AcceptEpisodes(const ActorRecord& actor, const Experience& experience) {
  for (const EpisodeResult& result : experience.episodes) {
    if (result.set != StartSet::kTraining) {
      evaluations_->Accept(result);
    } else if (result.vehicle >= 0 && result.vehicle < experiment_.num_vehicles) {
      if (result.outcome == Outcome::kDiverged) fleet_->CloseDiverged(actor, result);
      if (control_.lockstep) {
        rounds_->Add(result, fleet_->vehicles()[static_cast<size_t>(result.vehicle)].steps);
      } else {
        harvest_.episodes.push_back(result);
      }
    }
  }
}

}  // namespace cairn::learner
