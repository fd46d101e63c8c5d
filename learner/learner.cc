#include "learner/learner.h"

#include <algorithm>
#include <filesystem>

#include "common/core/check.h"
#include "common/core/clock.h"
#include "common/core/log.h"
#include "common/nn/policy_shape.h"

namespace cairn::learner {
namespace {

using std::chrono::milliseconds;

constexpr int64_t kAsyncUpdatesPerTurn = 16;  // between two looks at what has come in
constexpr int64_t kNoLimit = INT64_MAX;

}  // namespace

Learner::Learner(Bus* bus, const Experiment& experiment, const LearnerOptions& options)
    : bus_(bus),
      experiment_(experiment),
      options_(options),
      shape_(MakePolicyShape(experiment)),
      coordinator_(bus, experiment, options.experiment_hash, options.num_actors),
      replay_(experiment.learner.buffer_size, shape_.observation_size, shape_.action_size, experiment.learner.n_steps,
              experiment.learner.gamma),
      algorithm_(MakeAlgorithm(experiment.learner, shape_, experiment.seed)),
      report_(bus, experiment, options.run_dir, options.launch_us),
      evaluation_(
          experiment.evaluation, &coordinator_, [this] { return report_.wall_s(); },
          [this](const EvaluationReport& report, const EvaluationSummary& summary) {
            report_.OnEvaluation(report, summary);
          }),
      audit_("learner") {}

void Learner::Run() {
  coordinator_.Start();
  report_.Telemetry(Counters("starting"));
  if (coordinator_.WaitForFleet()) {
    log::Info("training starts: {} actors, policy {}", options_.num_actors, shape_.ToString());
    Publish();
    experiment_.schedule == Schedule::kLockstep ? RunLockstep() : RunAsync();
  }
  FinishRun();
}

// Receive, sample and update, publish, grant, evaluate. With overlap two rounds are open: round r + 1 rolls out, with
// the policy trained through round r − 1, while this thread trains on round r. Without, one is.
void Learner::RunLockstep() {
  GrantNextRound();
  if (experiment_.lockstep.overlap) GrantNextRound();
  while (env_steps_ < experiment_.total_env_steps) {
    const std::optional<Harvest> round = coordinator_.WaitRound();
    if (!round) return;
    Insert(*round);
    Train(kNoLimit);
    Publish();
    GrantNextRound();
    evaluation_.Visit(env_steps_, updates_, algorithm_->policy_parameters());
    report_.Visit(Counters("training"), algorithm_.get());
  }
}

// Every vehicle makes the same steps; the last round makes up the exact total, one step more for the first vehicles.
void Learner::GrantNextRound() {
  const int64_t vehicles = experiment_.num_vehicles;
  const int64_t left = experiment_.total_env_steps - granted_;
  if (left == 0) return;
  const int64_t steps = std::min<int64_t>(experiment_.lockstep.round_steps, left / vehicles);
  const bool last = steps < experiment_.lockstep.round_steps;
  const int64_t extra = last ? left % vehicles : 0;
  coordinator_.GrantRound(static_cast<int>(steps), static_cast<int>(extra),
                          granted_ < experiment_.learner.learning_starts);
  granted_ += steps * vehicles + extra;
}

// Credit runs ahead of the updates by the error buffer, updates never run ahead of the data (samples-per-insert band).
void Learner::RunAsync() {
  const LearnerConfig& config = experiment_.learner;
  TimePoint published = Clock::now();
  while (env_steps_ < experiment_.total_env_steps) {
    const int64_t paid = config.gradient_steps == 0
                             ? experiment_.total_env_steps
                             : config.learning_starts + updates_ / config.gradient_steps * config.train_freq;
    coordinator_.SetAllowed(paid + experiment_.async.error_buffer, env_steps_ < config.learning_starts);
    Insert(coordinator_.Take(UpdatesDue() > 0 ? Duration::zero() : Duration(milliseconds(5))));
    if (coordinator_.stopped()) return;
    Train(kAsyncUpdatesPerTurn);
    if (Clock::now() - published > milliseconds(20)) {
      Publish();
      published = Clock::now();
      evaluation_.Visit(env_steps_, updates_, algorithm_->policy_parameters());
      report_.Visit(Counters("training"), algorithm_.get());
    }
  }
  Train(kNoLimit);
  Publish();
  evaluation_.Visit(env_steps_, updates_, algorithm_->policy_parameters());
}

void Learner::Insert(const Harvest& harvest) {
  for (const Segment& segment : harvest.segments) {
    env_steps_ += replay_.Insert(segment);
    audit_.Add(segment, shape_.observation_size, shape_.action_size);
  }
  report_.OnEpisodes(harvest.episodes, env_steps_);
}

int64_t Learner::UpdatesDue() const {
  const LearnerConfig& config = experiment_.learner;
  if (env_steps_ < config.learning_starts || replay_.size() == 0) return 0;
  return (env_steps_ - config.learning_starts) / config.train_freq * config.gradient_steps - updates_;
}

int64_t Learner::Train(int64_t limit) {
  const int64_t count = std::min(UpdatesDue(), limit);
  if (count <= 0) return 0;
  algorithm_->Update(replay_, static_cast<int>(count), progress());
  updates_ += count;
  return count;
}

void Learner::Publish() { coordinator_.PublishPolicy(updates_, algorithm_->policy_parameters()); }

PolicySnapshot Learner::Snapshot() const {
  const std::span<const float> parameters = algorithm_->policy_parameters();
  return {updates_, env_steps_, std::vector<float>(parameters.begin(), parameters.end())};
}

void Learner::SaveSnapshot(const PolicySnapshot& snapshot, const std::string& name) const {
  if (options_.run_dir.empty()) return;
  const std::filesystem::path directory = std::filesystem::path(options_.run_dir) / "checkpoints";
  std::filesystem::create_directories(directory);
  SavePolicy({shape_, snapshot.parameters, snapshot.version, snapshot.env_steps, options_.experiment_hash},
             (directory / name).string());
}

RunCounters Learner::Counters(const char* phase) {
  RunCounters counters;
  counters.phase = phase;
  counters.env_steps = env_steps_;
  counters.updates = updates_;
  counters.replay_size = replay_.size();
  counters.stream = coordinator_.counters();
  counters.consumption_env_steps = evaluation_.consumption_env_steps();
  counters.consumption_wall_s = evaluation_.consumption_wall_s();
  counters.stays_solved = evaluation_.stays_solved();
  counters.last_solved = evaluation_.last_solved();
  return counters;
}

void Learner::FinishRun() {
  const PolicySnapshot last = Snapshot();
  SaveSnapshot(last, "last.policy");
  report_.TrainingEnded(Counters("testing"));
  RunResult result;
  if (env_steps_ >= experiment_.total_env_steps) {
    if (const std::optional<EvaluationSummary> test = evaluation_.Test(last)) {
      result.test = *test;
      completed_ = true;
    }
  }
  if (evaluation_.best()) SaveSnapshot(*evaluation_.best(), "best.policy");
  result.completed = completed_;
  result.policy_tested = evaluation_.best() ? "best" : "last";
  result.weights_crc32c = algorithm_->WeightsCrc32c();
  report_.Finish(Counters(completed_ ? "finished" : "stopped"), result);
  audit_.Flush();
  coordinator_.Finish();
}

}  // namespace cairn::learner
