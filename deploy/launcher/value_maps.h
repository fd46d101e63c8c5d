#pragma once

#include <memory>
#include <optional>
#include <string>

#include "actors/controllers/controller.h"
#include "actors/evaluation.h"
#include "deploy/launcher/run_directory.h"

namespace cairn::deploy {

// Pictures of a number for each place of a plane world, or of a horizontal slice through one in space at `height` [m]
// (left out: its middle). `scene` is one of evaluation (Scene::ForEvaluation) with a table. They throw UsageError for a
// height outside the world.

/// Q(s, π(s)), the smaller of both critics, for a vehicle at rest: the observation is an episode's first one without
/// noise, D_min = D(s), the mean over those of eight headings in which the footprint touches nothing. Networks come
/// from the run's newest checkpoint, `policy` is best (also when empty) or last; those of the best are there only with
/// learner.on_collapse REVERT_TO_BEST, otherwise the last ones are drawn and the picture says so. Throws UsageError
/// when there is no checkpoint, Error when networks and experiment do not fit.
void WriteQMap(const RunDirectory& run, const actors::Scene& scene, const std::string& policy,
               std::optional<double> height, const std::string& file);

/// The paper's discounted success score: gamma^steps of an episode that reaches the goal from there, 0 of one that does
/// not. Starts head along the roadmap. `driver` names the controller.
void WriteScoreMap(const std::shared_ptr<const actors::Scene>& scene, actors::Controller& controller,
                   actors::EvaluationOptions evaluation, const std::string& driver, std::optional<double> height,
                   const std::string& file);

}  // namespace cairn::deploy
