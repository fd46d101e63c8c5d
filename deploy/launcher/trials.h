#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "actors/controllers/controller.h"
#include "actors/evaluation.h"
#include "common/config/load.h"
#include "common/nn/policy.h"
#include "deploy/launcher/planned_world.h"
#include "deploy/launcher/run_directory.h"

namespace cairn::deploy {

/// A controller and what it is called.
struct Driver {
  std::string name;
  int64_t policy_version = 0;
  /// Each thread drives with one of its own.
  std::function<std::unique_ptr<actors::Controller>()> make;
};

/// Episodes at the same time in one batch.
constexpr int kMaxBatch = 32;

/// A policy of a run.
struct RunPolicy {
  PolicyFile file;
  std::string name;  ///< for people
};

/// `wanted` is best or last; empty: the best if there is one, else the last. Throws UsageError when there is none,
/// Error when it was trained with another experiment than `own`, the directory's.
RunPolicy OpenPolicy(const RunDirectory& run, const LoadedExperiment& own, const std::string& wanted);

/// The run's experiment with what was typed after --set, --seed and in place of its world. Throws UsageError when its
/// policy could not drive there: other observations or actions than in `own`, as the directory has it.
Experiment ChangedExperiment(const RunDirectory& run, const LoadedExperiment& own, std::vector<std::string> overrides,
                             std::optional<uint64_t> seed, const PlaceArguments& place = {});

/// `controller` pure_pursuit: the referee, on a roadmap of its own in the world of `experiment`, with room for its
/// whole footprint. Else the run's policy, as OpenPolicy has it.
Driver MakeDriver(const std::string& controller, const RunDirectory& run, const LoadedExperiment& own,
                  const std::string& wanted, const Experiment& experiment);

/// The scene of an experiment with the planned table.
std::shared_ptr<actors::Scene> MakePlannedScene(const Experiment& experiment, const PlannedWorld& planned);

/// Drives test starts 0 … trials − 1 on all CPUs; the results do not depend on their number. `trajectories`, when not
/// null, receives one per start.
std::vector<EpisodeResult> RunTrials(const std::shared_ptr<const actors::Scene>& scene, const Driver& driver,
                                     int trials, std::vector<actors::Trajectory>* trajectories = nullptr);

}  // namespace cairn::deploy
