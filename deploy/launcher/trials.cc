#include "deploy/launcher/trials.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <future>
#include <utility>

#include "actors/controllers/policy_controller.h"
#include "actors/controllers/pure_pursuit.h"
#include "common/core/check.h"
#include "common/nn/policy.h"
#include "deploy/launcher/cpus.h"
#include "deploy/launcher/local_tables.h"
#include "deploy/launcher/planned_world.h"

namespace cairn::deploy {
namespace {

// A policy controller with its network.
class NetworkController final : public actors::Controller {
 public:
  explicit NetworkController(const PolicyFile& file) : policy_(file.shape, kMaxBatch), controller_(policy_, kMaxBatch) {
    policy_.SetParameters(file.parameters);
  }
  void Act(std::span<const actors::Environment* const> environments, float* actions) override {
    controller_.Act(environments, actions);
  }

 private:
  Policy policy_;
  actors::PolicyController controller_;
};

std::string ChoosePolicy(const RunDirectory& run, const std::string& wanted) {
  const auto exists = [&](const std::string& which) { return std::filesystem::exists(run.policy_file(which)); };
  if (!wanted.empty()) {
    if (!exists(wanted)) ThrowUsageError("--policy {}: there is no {}", wanted, run.policy_file(wanted));
    return wanted;
  }
  for (const char* which : {"best", "last"}) {
    if (exists(which)) return which;
  }
  ThrowUsageError("run directory {}: no policy in checkpoints/; has the run ended?", run.path());
}

struct Share {
  std::vector<int> starts;
  std::vector<EpisodeResult> results;
  std::vector<actors::Trajectory> trajectories;
};

Driver MakePolicyDriver(const RunDirectory& run, const LoadedExperiment& own, const std::string& wanted) {
  const auto policy = std::make_shared<const RunPolicy>(OpenPolicy(run, own, wanted));
  return {policy->name, policy->file.version, [policy] { return std::make_unique<NetworkController>(policy->file); }};
}

Driver MakePurePursuitDriver(Experiment experiment) {
  experiment.planner = actors::PurePursuit::Planner(experiment);
  std::shared_ptr<actors::Scene> scene;
  try {
    scene = std::make_shared<actors::Scene>(experiment);
    scene->SetTable(PlanWorld(experiment, experiment.planner).MakeLookup());
  } catch (const UsageError& error) {  // it keeps farther from walls than the experiment's planner may
    ThrowUsageError("pure pursuit's own roadmap: {}", error.what());
  }
  return {fmt::format("pure pursuit (roadmap with {:.3f} m to walls)", experiment.planner.radius), 0,
          [scene = std::move(scene), tables = MakeLocalTables(experiment)] {
            return std::make_unique<actors::PurePursuit>(scene, tables);
          }};
}

}  // namespace

RunPolicy OpenPolicy(const RunDirectory& run, const LoadedExperiment& own, const std::string& wanted) {
  const std::string which = ChoosePolicy(run, wanted);
  RunPolicy policy{LoadPolicy(run.policy_file(which)), ""};
  const PolicyFile& file = policy.file;
  const int size = ObservationSize(own.experiment);
  if (file.experiment_hash != own.hash || file.shape.observation_size != size) {
    ThrowError("{}: trained with another experiment ({:016x}, {} observations) than the directory's ({:016x}, {})",
               run.policy_file(which), file.experiment_hash, file.shape.observation_size, own.hash, size);
  }
  policy.name = fmt::format("policy {} ({} env steps, {})", which, file.env_steps, file.shape.ToString());
  return policy;
}

Experiment ChangedExperiment(const RunDirectory& run, const LoadedExperiment& own, std::vector<std::string> overrides,
                             std::optional<uint64_t> seed, const PlaceArguments& place) {
  if (seed) overrides.push_back(fmt::format("seed={}", *seed));
  Experiment changed = LoadExperiment(run.experiment_file(), overrides, place).experiment;
  if (ObservationSize(changed) != ObservationSize(own.experiment) ||
      changed.vehicle.action_size() != own.experiment.vehicle.action_size()) {
    ThrowUsageError("--set {}: the policy takes {} observations and gives {} actions, and this makes {} and {}",
                    fmt::join(overrides, " "), ObservationSize(own.experiment), own.experiment.vehicle.action_size(),
                    ObservationSize(changed), changed.vehicle.action_size());
  }
  return changed;
}

Driver MakeDriver(const std::string& controller, const RunDirectory& run, const LoadedExperiment& own,
                  const std::string& wanted, const Experiment& experiment) {
  if (controller == "pure_pursuit") return MakePurePursuitDriver(experiment);
  return MakePolicyDriver(run, own, wanted);
}

std::shared_ptr<actors::Scene> MakePlannedScene(const Experiment& experiment, const PlannedWorld& planned) {
  auto scene = std::make_shared<actors::Scene>(experiment);
  scene->SetTable(planned.MakeLookup());
  return scene;
}

std::vector<EpisodeResult> RunTrials(const std::shared_ptr<const actors::Scene>& scene, const Driver& driver,
                                     int trials, std::vector<actors::Trajectory>* trajectories) {
  actors::EvaluationOptions options;
  options.policy_version = driver.policy_version;
  options.evaluation = actors::EvaluationOptions::KeyOf(driver.policy_version);
  options.max_batch = kMaxBatch;
  options.keep_marks = true;
  // Marks that are kept make a trial depend on those before it.
  const bool in_turn = scene->experiment().planner.repair_kept;
  std::vector<Share> shares(static_cast<size_t>(in_turn ? 1 : std::min(trials, AvailableCpus())));
  for (int start = 0; start < trials; ++start)
    shares[static_cast<size_t>(start) % shares.size()].starts.push_back(start);
  std::vector<std::future<void>> threads;
  for (Share& share : shares) {
    threads.push_back(std::async(std::launch::async, [&share, &options, &scene, &driver, trajectories] {
      const std::unique_ptr<actors::Controller> controller = driver.make();
      share.results = actors::RunEpisodes(MakeLocalCourse(scene), StartSet::kTest, share.starts, *controller, options,
                                          trajectories == nullptr ? nullptr : &share.trajectories);
    }));
  }
  for (std::future<void>& thread : threads) thread.get();  // also rethrows
  std::vector<EpisodeResult> results(static_cast<size_t>(trials));
  if (trajectories != nullptr) trajectories->resize(static_cast<size_t>(trials));
  for (Share& share : shares) {
    for (size_t i = 0; i < share.starts.size(); ++i) {
      const auto start = static_cast<size_t>(share.starts[i]);
      results[start] = share.results[i];
      if (trajectories != nullptr) (*trajectories)[start] = std::move(share.trajectories[i]);
    }
  }
  return results;
}

}  // namespace cairn::deploy
