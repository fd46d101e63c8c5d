#include "learner/checkpoint/run_fields.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/core/check.h"

namespace cairn::learner {

RunFields NetworkFields(const Experiment& experiment) {
  const LearnerConfig& learner = experiment.learner;
  return {{"learner.algorithm", learner.algorithm == LearnerConfig::Algorithm::kSac ? "SAC" : "TD3"},
          {"learner.net_arch", fmt::format("[{}]", fmt::join(learner.net_arch, ", "))},
          {"learner.layer_norm", learner.layer_norm ? "true" : "false"},
          {"observation size", std::to_string(ObservationSize(experiment))}};
}

RunFields ResumeFields(const Experiment& experiment) {
  const LearnerConfig& learner = experiment.learner;
  RunFields fields = NetworkFields(experiment);
  fields.insert(
      fields.end(),
      {{"schedule", experiment.schedule == Schedule::kLockstep ? "LOCKSTEP" : "ASYNC"},
       {"num_vehicles", std::to_string(experiment.num_vehicles)},
       {"seed", std::to_string(experiment.seed)},
       {"world.seed", std::to_string(experiment.world.seed)},
       {"vehicle.kind", experiment.vehicle.kind == VehicleConfig::Kind::kWheeledCar ? "WHEELED_CAR" : "PLANE_CAR"},
       {"learner.buffer_size", std::to_string(learner.buffer_size)},
       {"learner.n_steps", std::to_string(learner.n_steps)},
       {"learner.gamma", fmt::format("{}", learner.gamma)},
       {"learner.learning_starts", std::to_string(learner.learning_starts)},
       {"learner.train_freq", std::to_string(learner.train_freq)},
       {"learner.gradient_steps", std::to_string(learner.gradient_steps)}});
  return fields;
}

void CheckFields(const RunFields& ours, const RunFields& theirs, const std::string& where) {
  std::string differences;
  for (const auto& mine : ours) {
    const auto field = std::find_if(theirs.begin(), theirs.end(), [&](const auto& f) { return f.first == mine.first; });
    const std::string other = field == theirs.end() ? "not known" : field->second;
    if (other == mine.second) continue;
    if (!differences.empty()) differences += "; ";
    differences += fmt::format("{} is {} there, {} here", mine.first, other, mine.second);
  }
  if (!differences.empty()) ThrowUsageError("{}: {}", where, differences);
}

}  // namespace cairn::learner
