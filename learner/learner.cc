#include "learner/learner.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/core/check.h"
#include "common/core/clock.h"
#include "common/core/files.h"
#include "common/core/log.h"
#include "common/core/version.h"
#include "common/nn/policy_shape.h"
#include "learner/checkpoint/run_fields.h"

namespace cairn::learner {
namespace {

using std::chrono::milliseconds;

constexpr int64_t kUpdatesPerTurn = 16;  // between two looks at what has come in, or whether to stop
constexpr int64_t kNoLimit = INT64_MAX;
constexpr auto kSettleTime = milliseconds(500);  // for the updates that are due before a checkpoint (ASYNC)
constexpr auto kLogVisit = milliseconds(100);    // between two looks at evaluations while a log is read
// In which a stopped run may still reach a checkpoint: the round at hand, one that is open, and one that gives the
// vehicles' states. cairn waits longer (deploy/launcher/train.cc).
constexpr auto kStopTime = std::chrono::seconds(10);

std::string CheckpointDirectory(const std::string& run_dir) { return run_dir + "/checkpoints"; }

std::unique_ptr<ProgressFile> OpenProgress(const std::string& run_dir) {
  if (run_dir.empty()) return nullptr;
  std::filesystem::create_directories(CheckpointDirectory(run_dir));
  return std::make_unique<ProgressFile>(CheckpointDirectory(run_dir) + "/progress");
}

// Leaves `steps` transitions in it, so that a run ends exactly where it shall.
void Shorten(Harvest* harvest, int64_t steps) {
  for (Segment& segment : harvest->segments) {
    const int64_t excess = segment.num_steps() - steps;
    steps = std::max<int64_t>(0, steps - segment.num_steps());
    if (excess <= 0) continue;
    const size_t kept = segment.rewards.size() - static_cast<size_t>(excess);
    const size_t observation = segment.observations.size() / (segment.rewards.size() + 1);
    segment.actions.resize(segment.actions.size() / segment.rewards.size() * kept);
    segment.observations.resize(observation * (kept + 1));
    segment.rewards.resize(kept);
    segment.end = SegmentEnd::kNone;
  }
  std::erase_if(harvest->segments, [](const Segment& s) { return s.num_steps() == 0; });
}

}  // namespace

Learner::Learner(Bus* bus, const Experiment& experiment, const LearnerOptions& options)
    : bus_(bus),
      experiment_(experiment),
      options_(options),
      shape_(MakePolicyShape(experiment)),
      progress_(OpenProgress(options.run_dir)),
      coordinator_(bus, experiment, options.experiment_hash, options.num_actors,
                   progress_ ? progress_->incarnation() : 1),
      replay_(experiment.learner.buffer_size, shape_.observation_size, shape_.action_size, experiment.learner.n_steps,
              experiment.learner.gamma),
      algorithm_(MakeAlgorithm(experiment.learner, shape_, experiment.seed)),
      report_(bus, experiment, options.run_dir, options.launch_us),
      evaluation_(
          experiment.evaluation, experiment.learner.collapse_checks, &coordinator_, [this] { return report_.wall_s(); },
          [this](const EvaluationReport& report, const EvaluationSummary& summary) {
            report_.OnEvaluation(report, summary);
          }),
      collapse_guard_(experiment, &evaluation_, algorithm_.get()),
      audit_(fmt::format("learner-{:02}", progress_ ? progress_->incarnation() : 1)) {}

void Learner::Run() {
  if (!options_.replay_log.empty()) {
    log_ = std::make_unique<LoggedExperience>(
        options_.replay_log, options_.replay_key,
        LoggedExperience::Shape{shape_.observation_size, shape_.action_size, options_.experiment_hash});
  }
  Prepare();
  coordinator_.Start();
  report_.Telemetry(Counters("starting"));
  if (coordinator_.WaitForFleet()) {
    log::Info("training starts: {} actors, policy {}", options_.num_actors, shape_.ToString());
    training_ = true;
    report_.Telemetry(Counters("training"));
    try {
      if (log_) {
        RunFromLog();
      } else {
        experiment_.schedule == Schedule::kLockstep ? RunLockstep() : RunAsync();
      }
    } catch (const Error& error) {
      WriteDiagnostic(error.what());
      throw;
    }
    training_ = false;
  }
  FinishRun();
}

void Learner::RequestStop() {
  stop_requested_ = true;
  training_ ? coordinator_.StopWithin(kStopTime) : coordinator_.Stop();
}

void Learner::Prepare() {
  if (options_.resume && !ListCheckpoints(CheckpointDirectory(options_.run_dir)).empty()) {
    Restore();
  } else {
    report_.Open();
    lost_with_learner_ = progress_ ? progress_->env_steps_before() : 0;
    rolled_back_ = lost_with_learner_ + (progress_ ? progress_->rolled_back_before() : 0);
    if (!experiment_.learner.init_from.empty()) InitFrom(experiment_.learner.init_from);
  }
  if (!options_.run_dir.empty()) {
    checkpointer_ =
        std::make_unique<Checkpointer>(CheckpointDirectory(options_.run_dir), experiment_.learner.checkpoints_kept);
    if (experiment_.schedule == Schedule::kAsync) coordinator_.KeepUntilDurable();
  }
  last_checkpoint_ = Clock::now();
}

void Learner::Restore() {
  const std::string directory = CheckpointDirectory(options_.run_dir);
  RunState state = LoadNewestCheckpoint(directory, ResumeFields(experiment_), &replay_);
  if (state.git_revision != GitRevision()) {
    log::Warning("the checkpoint was written by revision {}, this is {}", state.git_revision, GitRevision());
  }
  algorithm_->Load(state.algorithm);
  env_steps_ = state.env_steps;
  updates_ = state.updates;
  granted_ = state.granted;
  lost_with_learner_ = std::max<int64_t>(0, progress_->env_steps_before() - env_steps_);
  rolled_back_ = std::max(state.transitions_rolled_back, progress_->rolled_back_before()) + lost_with_learner_;
  coordinator_.Restore(state.coordinator, env_steps_);
  evaluation_.Restore(state.evaluation);
  collapse_guard_.Restore(std::move(state.candidates));
  CheckTotal(state.coordinator.granted);
  report_.Open(state.wall_s, state.episode_log_bytes);
  log::Info("resumed at {} env steps, {} updates; {} transitions rolled back", env_steps_, updates_,
            lost_with_learner_);
  resumed_ = std::move(state);
}

// A run that goes on after its old end goes on for a step of every vehicle; for another one when some have made an
// extra step there, which the others catch up with first.
void Learner::CheckTotal(const std::vector<RoundState>& open) const {
  if (experiment_.schedule != Schedule::kLockstep || experiment_.total_env_steps <= granted_) return;
  const bool level = coordinator_.rounds_level() && (open.empty() || open.back().extra == 0);
  const int64_t least = int64_t{level ? 1 : 2} * experiment_.num_vehicles;
  if (experiment_.total_env_steps >= granted_ + least) return;
  ThrowUsageError("total_env_steps = {}: a run of {} env steps goes on for at least {} more, {} for each vehicle",
                  experiment_.total_env_steps, granted_, least, level ? "one" : "two");
}

void Learner::InitFrom(const std::string& run_dir) {
  const std::string directory = CheckpointDirectory(run_dir);
  const RunState state = ReadNewestCheckpoint(directory);
  CheckFields(NetworkFields(experiment_), state.fields, "learner.init_from " + run_dir);
  algorithm_->LoadNetworks(state.algorithm);
  log::Info("networks from {}, {} env steps", run_dir, state.env_steps);
}

// A new run opens its first rounds with the first policy. One that goes on opens those that were open, with the
// policies that they had, and asks again for the evaluations that were under way.
void Learner::StartRounds() {
  if (resumed_) {
    for (const RoundState& round : resumed_->coordinator.granted) {
      const bool last = &round == &resumed_->coordinator.granted.back();
      saving_ = checkpointer_ && last && granted_ >= experiment_.total_env_steps;
      coordinator_.PublishPolicy(round.policy.version, round.policy.parameters);
      coordinator_.GrantRound(round.steps, round.extra, round.warm_up, saving_);
    }
  }
  Publish();
  if (resumed_) evaluation_.AskAgain(resumed_->evaluation);
  GrantRounds();
  resumed_.reset();
}

// Receive, sample and update, publish, evaluate, save, grant. With overlap two rounds are open: round r + 1 rolls out,
// with the policy trained through round r − 1, while this thread trains on round r. Without, one is.
void Learner::RunLockstep() {
  StartRounds();
  while (coordinator_.open_rounds() > 0) {
    std::optional<Harvest> round = coordinator_.WaitRound();
    if (!round) return;
    Insert(*round);
    while (Train(kUpdatesPerTurn) > 0) {
      if (coordinator_.stopped()) return;
    }
    PublishAndEvaluate();
    if (!round->vehicles.empty()) {
      saving_ = false;
      SaveRound(&*round);
      if (stop_requested_) return coordinator_.Stop();
    }
    GrantRounds();
    report_.Visit(Counters("training"), algorithm_.get());
  }
}

void Learner::GrantRounds() {
  const int most = experiment_.lockstep.overlap ? 2 : 1;
  while (coordinator_.open_rounds() < most && GrantNextRound()) {
  }
}

// Every vehicle makes the same steps; the last round makes up the exact total, one step more for the first vehicles.
// No vehicle stands still in it, since its checkpoint needs the state of each. A resumed run whose total is larger goes
// on behind that round, one whose total is smaller ends with the rounds that were open. False when there is nothing to
// grant.
bool Learner::GrantNextRound() {
  const int64_t vehicles = experiment_.num_vehicles;
  const int64_t left = experiment_.total_env_steps - granted_;
  const bool level = coordinator_.rounds_level();
  if (left <= 0 || (!level && coordinator_.open_rounds() > 0)) return false;
  const int64_t steps = std::min<int64_t>(experiment_.lockstep.round_steps, left / vehicles);
  const bool last = left < (steps + 1) * vehicles;
  const int64_t extra = last ? left % vehicles : 0;
  // One at a time, and in any case the last.
  const bool save = level && checkpointer_ && (last || (!saving_ && (CheckpointDue() || stop_requested_)));
  saving_ = saving_ || save;
  const bool warm_up = granted_ < experiment_.learner.learning_starts;
  granted_ += level ? coordinator_.GrantRound(static_cast<int>(steps), static_cast<int>(extra), warm_up, save)
                    : coordinator_.GrantRound(1, 0, warm_up);
  return true;
}

// Credit runs ahead of the updates by the error buffer, updates never run ahead of the data (samples-per-insert band).
// The buffer holds what the next updates need at least, or neither side could go on.
void Learner::RunAsync() {
  const LearnerConfig& config = experiment_.learner;
  const int64_t ahead = std::max(experiment_.async.error_buffer, config.train_freq);
  TimePoint published = Clock::now();
  Publish();
  if (resumed_) evaluation_.AskAgain(resumed_->evaluation);
  resumed_.reset();
  while (env_steps_ < experiment_.total_env_steps) {
    const int64_t paid = config.gradient_steps == 0
                             ? experiment_.total_env_steps
                             : config.learning_starts + updates_ / config.gradient_steps * config.train_freq;
    coordinator_.SetAllowed(paid + ahead, env_steps_ < config.learning_starts);
    Insert(coordinator_.Take(UpdatesDue() > 0 ? Duration::zero() : Duration(milliseconds(5))));
    if (stop_requested_) {
      SettleAndSave();
      coordinator_.Stop();
    }
    if (coordinator_.stopped()) return;
    Train(kUpdatesPerTurn);
    if (Clock::now() - published > coordinator_.publish_interval()) {
      PublishAndEvaluate();
      published = Clock::now();
      NoteDurable();
      if (CheckpointDue()) SettleAndSave();
      report_.Visit(Counters("training"), algorithm_.get());
    }
  }
  Train(kNoLimit);
  PublishAndEvaluate();
  SettleAndSave();
}

// What others lived through, in the order of the log; actors only evaluate. Whatever the schedule, the same log, file
// and seed give the same weights. One checkpoint at the end: it is what --resume and learner.init_from go on from, and
// a learner that died before begins the log again.
void Learner::RunFromLog() {
  Publish();
  if (resumed_) {
    log_ended_ = true;
    log::Info("--replay-log {}: was read to its end before", options_.replay_log);
    evaluation_.AskAgain(resumed_->evaluation);
    resumed_.reset();
    return;
  }
  TimePoint published = Clock::now();
  while (env_steps_ < experiment_.total_env_steps && !stop_requested_) {
    std::optional<Harvest> next = log_->Next();
    if (!next) break;
    Shorten(&*next, experiment_.total_env_steps - env_steps_);
    Insert(*next);
    Train(kNoLimit);
    if (evaluation_.CheckDue(env_steps_) || Clock::now() - published > kLogVisit) {
      PublishAndEvaluate();
      published = Clock::now();
      report_.Visit(Counters("training"), algorithm_.get());
    }
  }
  if (stop_requested_) return coordinator_.Stop();
  log_ended_ = true;
  granted_ = env_steps_;
  PublishAndEvaluate();
  const std::string trouble = log_->counters().Trouble();
  log::Info("--replay-log {}: {} transitions of {} messages{}{}", options_.replay_log, env_steps_,
            log_->counters().messages, trouble.empty() ? "" : "; ", trouble);
  if (!trouble.empty()) log::Warning("--replay-log {}: {}", options_.replay_log, trouble);
  if (checkpointer_) {
    Harvest none;
    Save(coordinator_.State(&none));
  }
}

// ASYNC: makes the updates that are due before it saves, so that a run that goes on has none to catch up with in a
// burst.
void Learner::SettleAndSave() {
  if (!checkpointer_) return;
  Harvest rest;
  CoordinatorState coordinator = coordinator_.State(&rest);
  Insert(rest);
  const TimePoint start = Clock::now();
  while (Train(kUpdatesPerTurn) > 0 && Clock::now() - start < kSettleTime) {
  }
  Save(std::move(coordinator));
}

bool Learner::CheckpointDue() const {
  return checkpointer_ && !checkpointer_->busy() &&
         SecondsSince(last_checkpoint_) >= experiment_.learner.checkpoint_interval_s;
}

// LOCKSTEP: the round has the vehicles' states, unless an actor died in it; then the next one is tried.
void Learner::SaveRound(Harvest* round) {
  if (!checkpointer_) return;
  const bool whole = std::all_of(round->vehicles.begin(), round->vehicles.end(),
                                 [](const VehicleState& v) { return !v.environment.empty(); });
  if (!whole) return log::Warning("no checkpoint at {} env steps: states are missing", env_steps_);
  Save(coordinator_.State(round));
}

void Learner::Save(CoordinatorState coordinator) {
  audit_.Flush();
  checkpointer_->Wait();
  NoteDurable();
  last_checkpoint_ = Clock::now();
  undurable_[env_steps_] = coordinator.sessions;
  checkpointer_->Write(State(std::move(coordinator)), &replay_);
  log::Info("checkpoint at {} env steps handed over in {:.2f} ms", env_steps_, 1e3 * SecondsSince(last_checkpoint_));
}

// Tells the actors what has reached the disk meanwhile.
void Learner::NoteDurable() {
  if (!checkpointer_ || undurable_.empty() || checkpointer_->busy()) return;
  const auto written = undurable_.find(checkpointer_->status().env_steps);
  if (written != undurable_.end()) coordinator_.SetDurable(written->second);
  undurable_.clear();
}

RunState Learner::State(CoordinatorState coordinator) {
  RunState state;
  state.fields = ResumeFields(experiment_);
  state.git_revision = GitRevision();
  state.env_steps = env_steps_;
  state.updates = updates_;
  state.granted = granted_;
  state.transitions_rolled_back = RolledBack();
  state.wall_s = report_.wall_s();
  state.episode_log_bytes = report_.FlushEpisodes();
  state.algorithm = algorithm_->Save();
  state.coordinator = std::move(coordinator);
  state.evaluation = evaluation_.State();
  state.candidates = collapse_guard_.candidates();
  state.policies.emplace_back("last.policy", ToFile(Snapshot()));
  if (evaluation_.best()) state.policies.emplace_back("best.policy", ToFile(*evaluation_.best()));
  return state;
}

void Learner::WriteDiagnostic(const std::string& error) {
  if (options_.run_dir.empty()) return;
  const UpdateInfo info = algorithm_->TakeInfo();
  nlohmann::ordered_json json;
  json["error"] = error;
  json["env_steps"] = env_steps_;
  json["updates"] = updates_;
  json["bad_updates"] = info.bad_updates;
  json["critic_loss"] = info.critic_loss;
  json["actor_loss"] = info.actor_loss;
  json["alpha"] = info.alpha;
  json["mean_q"] = info.mean_q;
  json["newest_checkpoint_env_steps"] = checkpointer_->status().env_steps;
  json["replay_size"] = replay_.size();
  WriteFileAtomically(options_.run_dir + "/diagnostic.json", json.dump(2) + "\n");
}

void Learner::Insert(const Harvest& harvest) {
  for (const Segment& segment : harvest.segments) {
    env_steps_ += replay_.Insert(segment);
    audit_.Add(segment, shape_.observation_size, shape_.action_size);
  }
  report_.OnEpisodes(harvest.episodes, env_steps_);
  if (progress_) progress_->Write(env_steps_, RolledBack());
}

int64_t Learner::UpdatesDue() const {
  const LearnerConfig& config = experiment_.learner;
  if (env_steps_ < config.learning_starts || replay_.size() == 0) return 0;
  return (env_steps_ - config.learning_starts) / config.train_freq * config.gradient_steps - updates_;
}

int64_t Learner::Train(int64_t limit) {
  const int64_t count = std::min(UpdatesDue(), limit);
  if (count <= 0) return 0;
  algorithm_->Update(replay_, static_cast<int>(count), run_share());
  updates_ += count;
  return count;
}

// What living actors had kept and sent again is not lost after all.
int64_t Learner::RolledBack() const {
  return rolled_back_ - std::min(lost_with_learner_, coordinator_.counters().recovered);
}

void Learner::Publish() { coordinator_.PublishPolicy(updates_, algorithm_->policy_parameters()); }

void Learner::PublishAndEvaluate() {
  collapse_guard_.BeforePublish(env_steps_);
  Publish();
  collapse_guard_.Visit(env_steps_, updates_);
}

PolicySnapshot Learner::Snapshot() const {
  const std::span<const float> parameters = algorithm_->policy_parameters();
  return {updates_, env_steps_, std::vector<float>(parameters.begin(), parameters.end())};
}

PolicyFile Learner::ToFile(const PolicySnapshot& snapshot) const {
  return {shape_, snapshot.parameters, snapshot.version, snapshot.env_steps, options_.experiment_hash};
}

// What went wrong; the run's other results shall not be lost with it.
std::string Learner::TrySave(const PolicySnapshot& snapshot, const std::string& name) const {
  if (options_.run_dir.empty()) return "";
  try {
    SavePolicy(ToFile(snapshot), CheckpointDirectory(options_.run_dir) + "/" + name);
    return "";
  } catch (const Error& error) {
    log::Error("{}", error.what());
    return error.what();
  }
}

RunCounters Learner::Counters(const char* phase) {
  RunCounters counters;
  counters.phase = phase;
  counters.rolled_back = RolledBack();
  counters.warning = collapse_guard_.warning();
  if (checkpointer_ && !checkpointer_->status().error.empty()) counters.warning = checkpointer_->status().error;
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
  if (checkpointer_) checkpointer_->Wait();  // it writes the same files
  std::string failure = TrySave(last, "last.policy");
  report_.TrainingEnded(Counters("testing"));
  RunResult result;
  if (env_steps_ >= experiment_.total_env_steps || log_ended_) {
    if (const std::optional<EvaluationSummary> test = evaluation_.Test(last)) {
      result.test = *test;
      completed_ = true;
    }
  }
  if (evaluation_.best()) failure += TrySave(*evaluation_.best(), "best.policy");
  result.completed = completed_;
  if (log_) result.log = {options_.replay_log, log_->counters()};
  result.policy_tested = evaluation_.best() ? "best" : "last";
  result.weights_crc32c = algorithm_->WeightsCrc32c();
  result.bad_updates = algorithm_->TakeInfo().bad_updates;
  report_.Finish(Counters(completed_ ? "finished" : "stopped"), result);
  audit_.Flush();
  coordinator_.Finish();
  if (!failure.empty()) ThrowError("{}", failure);
}

}  // namespace cairn::learner
