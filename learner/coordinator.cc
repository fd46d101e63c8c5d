#include "learner/coordinator.h"

#include <algorithm>

#include "common/core/check.h"
#include "common/core/hash.h"
#include "common/core/log.h"
#include "common/core/version.h"

namespace cairn::learner {
namespace {

using std::chrono::milliseconds;

constexpr auto kMinControlGap = milliseconds(5);  // 200 Hz at most
constexpr auto kReannounce = milliseconds(20);    // until acted on
constexpr auto kIdleAnnounce = milliseconds(1000);
constexpr auto kPolicyResendGap = milliseconds(10);  // several actors may ask for the same version at once
constexpr size_t kKeptPolicies = 4;

}  // namespace

Coordinator::Coordinator(Bus* bus, const Experiment& experiment, uint64_t experiment_hash, int num_actors)
    : bus_(bus),
      experiment_(experiment),
      observation_size_(ObservationSize(experiment)),
      tables_(bus, experiment_hash),
      fleet_(num_actors, experiment.num_vehicles, experiment_hash, observation_size_, GitRevision()) {
  control_.incarnation = RandomId();
  control_.lockstep = experiment.schedule == Schedule::kLockstep;
  fleet_.set_incarnation(control_.incarnation);
}

Coordinator::~Coordinator() { Stop(); }

void Coordinator::Start() {
  bus_->Subscribe<Hello>(Plane::kExperience, kHelloChannel,
                         [this](const Hello& hello, const FrameInfo&) { OnHello(hello); });
  bus_->Subscribe<ActorStatus>(Plane::kExperience, kStatusChannel,
                               [this](const ActorStatus& status, const FrameInfo&) { OnStatus(status); });
  bus_->Subscribe<Experience>(Plane::kExperience, kExperienceChannels,
                              [this](const Experience& e, const FrameInfo&) { OnExperience(e); });
  bus_->CheckPlanes();
  tables_.RequestInfo();
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void Coordinator::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    bus_->Poll(kMinControlGap);
    const TimePoint now = Clock::now();
    tables_.Poll(now);
    const std::lock_guard lock(mutex_);
    if (control_.table_hash == 0 && tables_.info()) {
      table_info_ = *tables_.info();
      control_.roadmap_hash = table_info_.roadmap_hash;
      control_.table_hash = table_info_.table_hash;
      dirty_ = true;
      changed_.notify_all();
    }
    GiveUpSilentActors(now);
    AnnounceIfDue(now);
  }
}

void Coordinator::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_all();
}

bool Coordinator::stopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_;
}

bool Coordinator::WaitForFleet() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return stopped_ || (fleet_.complete() && control_.table_hash != 0); });
  if (stopped_) return false;
  control_.phase = Control::Phase::kRunning;
  dirty_ = true;
  fleet_.set_started();
  return true;
}

void Coordinator::Finish() {
  Stop();
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  const std::lock_guard lock(mutex_);
  control_.phase = Control::Phase::kFinished;
  for (int i = 0; i < 3; ++i) SendControl(Clock::now());
}

// --- what comes in ---------------------------------------------------------------------------------------------------

void Coordinator::OnHello(const Hello& hello) {
  const std::lock_guard lock(mutex_);
  const auto holder = fleet_.actors().find(hello.actor_id);
  const int64_t held_accepted = holder == fleet_.actors().end() ? 0 : holder->second.accepted;
  const int64_t held_session = holder == fleet_.actors().end() ? 0 : holder->second.session;
  const Welcome welcome = fleet_.Join(hello, Clock::now());
  if (welcome.status != Welcome::Status::kAccepted) {
    ++counters_.refused;
    log::Warning("actor {} refused: {}", hello.actor_id, welcome.reason);
  } else if (held_session != hello.session) {
    retired_accepted_ += held_accepted;
    dirty_ = true;
    changed_.notify_all();
  }
  bus_->Publish(Plane::kControl, kWelcomeChannel, welcome);
}

void Coordinator::OnStatus(const ActorStatus& status) {
  const std::lock_guard lock(mutex_);
  ActorRecord* actor = fleet_.Find(status.session);
  if (actor == nullptr) return;
  const TimePoint now = Clock::now();
  actor->last_heard = now;
  if (status.assignment < fleet_.Assignment(*actor).assignment) {
    bus_->Publish(Plane::kControl, kWelcomeChannel, fleet_.Assignment(*actor));
  }
  const auto wanted = policies_.find(status.wanted_policy_version);
  if (wanted != policies_.end() && now - policy_sent_at_[wanted->first] > kPolicyResendGap) {
    SendPolicy(wanted->first, wanted->second);
  }
}

void Coordinator::OnExperience(const Experience& experience) {
  const std::lock_guard lock(mutex_);
  ActorRecord* actor = fleet_.Find(experience.session);
  if (actor == nullptr || experience.observation_size != observation_size_ || experience.action_size != kActionSize) {
    ++counters_.refused;
    return;
  }
  actor->last_heard = Clock::now();
  actor->echo_utime = experience.utime;
  dirty_ = true;
  switch (actor->stream.Accept(experience.sequence)) {
    case ReliableReceiver::Verdict::kDuplicate:
      ++counters_.stream_duplicates;
      return;
    case ReliableReceiver::Verdict::kGap:
      return;  // go-back: the sender starts again from the first missing one
    case ReliableReceiver::Verdict::kNew:
      break;
  }
  AcceptEpisodes(*actor, experience);
  AcceptSegments(actor, experience);
  if (control_.lockstep) UpdateRoundProgress();
  changed_.notify_all();
}

void Coordinator::AcceptSegments(ActorRecord* actor, const Experience& experience) {
  for (const Segment& segment : experience.segments) {
    if (segment.table_hash != control_.table_hash || segment.policy_incarnation != control_.incarnation ||
        !SoundForRound(segment)) {
      ++counters_.refused;
      log::Warning(
          "actor {}: segment of vehicle {} refused: table {:016x}, policy {:016x} version {}; in force are "
          "table {:016x}, policy {:016x} version {}, {} steps missing in the round",
          actor->actor_id, segment.vehicle, segment.table_hash, segment.policy_incarnation, segment.policy_version,
          control_.table_hash, control_.incarnation, control_.policy_version, round_steps_missing_);
      continue;
    }
    switch (fleet_.Accept(*actor, segment)) {
      case Fleet::Verdict::kAccepted:
        break;
      case Fleet::Verdict::kDuplicate:
        counters_.transitions_duplicate += segment.num_steps();
        continue;
      case Fleet::Verdict::kGap:
        counters_.transitions_lost += segment.num_steps();
        log::Error("actor {}: vehicle {} episode {} step {} does not continue what was received", actor->actor_id,
                   segment.vehicle, segment.episode, segment.first_step);
        continue;
      case Fleet::Verdict::kForeign:
      case Fleet::Verdict::kNotFinite:
        ++counters_.refused;
        continue;
    }
    actor->accepted += segment.num_steps();
    counters_.transitions_accepted += segment.num_steps();
    counters_.policy_lag_sum += static_cast<double>(newest_version_ - segment.policy_version);
    ++counters_.policy_lag_count;
    harvest_.segments.push_back(segment);
  }
}

bool Coordinator::SoundForRound(const Segment& segment) const {
  if (!control_.lockstep) return true;
  return segment.policy_version == control_.policy_version && round_steps_missing_ >= segment.num_steps();
}

void Coordinator::UpdateRoundProgress() {
  int64_t missing = 0;
  for (size_t v = 0; v < fleet_.vehicles().size(); ++v) {
    const int extra = static_cast<int>(v) < control_.round_extra ? 1 : 0;
    missing += std::max(0, control_.round_steps + extra - fleet_.vehicles()[v].round_steps);
  }
  round_steps_missing_ = missing;
}

void Coordinator::AcceptEpisodes(const ActorRecord& actor, const Experience& experience) {
  for (const EpisodeResult& result : experience.episodes) {
    if (result.set == StartSet::kTraining) {
      if (result.outcome == Outcome::kDiverged) fleet_.CloseDiverged(actor, result);
      harvest_.episodes.push_back(result);
    } else {
      AcceptEvaluation(result);
    }
  }
}

void Coordinator::AcceptEvaluation(const EpisodeResult& result) {
  if (evaluations_.empty() || result.episode != evaluations_.front().id) return;
  PendingEvaluation& evaluation = evaluations_.front();
  if (result.vehicle < 0 || result.vehicle >= static_cast<int32_t>(evaluation.results.size())) return;
  auto& slot = evaluation.results[static_cast<size_t>(result.vehicle)];
  if (slot) return;  // a replaced actor did it again
  slot = result;
  counters_.eval_steps += result.steps;
  if (--evaluation.missing > 0) return;
  EvaluationReport report{evaluation.request, {}};
  for (const auto& r : evaluation.results) report.results.push_back(*r);
  reports_.push_back(std::move(report));
  evaluations_.pop_front();
  NextEvaluation();
}

// --- what goes out ---------------------------------------------------------------------------------------------------

void Coordinator::PublishPolicy(int64_t version, std::span<const float> parameters) {
  const std::lock_guard lock(mutex_);
  newest_version_ = version;
  if (!control_.lockstep) control_.policy_version = version;
  KeepPolicy(version, parameters);
  dirty_ = true;
}

void Coordinator::KeepPolicy(int64_t version, std::span<const float> parameters) {
  SharedParameters& slot = policies_[version];
  if (!slot) {
    slot = std::make_shared<std::vector<float>>(parameters.begin(), parameters.end());
    SendPolicy(version, slot);
  }
  DropUnusedPolicies();
}

void Coordinator::DropUnusedPolicies() {
  for (auto it = policies_.begin(); it != policies_.end() && policies_.size() > kKeptPolicies;) {
    const int64_t version = it->first;
    const bool evaluated = std::any_of(evaluations_.begin(), evaluations_.end(),
                                       [version](const auto& e) { return e.request.version == version; });
    if (evaluated || version == control_.policy_version || version == newest_version_) {
      ++it;
    } else {
      policy_sent_at_.erase(version);
      it = policies_.erase(it);
    }
  }
}

void Coordinator::SendPolicy(int64_t version, const SharedParameters& parameters) {
  const auto chunk = static_cast<size_t>((MaxMessageBytes(experiment_.transport.ttl) - 128) / 4);
  PolicyChunk message;
  message.incarnation = control_.incarnation;
  message.version = version;
  message.parameters_crc = Crc32c(parameters->data(), parameters->size() * sizeof(float));
  message.total = static_cast<int32_t>(parameters->size());
  for (size_t at = 0; at < parameters->size(); at += chunk) {
    const size_t end = std::min(at + chunk, parameters->size());
    message.offset = static_cast<int32_t>(at);
    message.parameters.assign(parameters->begin() + static_cast<std::ptrdiff_t>(at),
                              parameters->begin() + static_cast<std::ptrdiff_t>(end));
    bus_->Publish(Plane::kControl, kPolicyChannel, message);
  }
  policy_sent_at_[version] = Clock::now();
}

void Coordinator::GrantRound(int steps, int extra, bool warm_up) {
  const std::lock_guard lock(mutex_);
  ++control_.round;
  control_.round_steps = steps;
  control_.round_extra = extra;
  control_.warm_up = warm_up;
  control_.policy_version = newest_version_;
  fleet_.set_round(control_.round);
  fleet_.StartRound();
  UpdateRoundProgress();
  SendControl(Clock::now());
}

std::optional<Harvest> Coordinator::WaitRound() {
  Harvest round;
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopped_ || round_steps_missing_ == 0; });
    if (stopped_) return std::nullopt;
    std::swap(round, harvest_);
  }
  // What one vehicle makes arrives in order; only the interleaving of vehicles depends on timing.
  const auto by_vehicle = [](const auto& a, const auto& b) { return a.vehicle < b.vehicle; };
  std::stable_sort(round.segments.begin(), round.segments.end(), by_vehicle);
  std::stable_sort(round.episodes.begin(), round.episodes.end(), by_vehicle);
  return round;
}

void Coordinator::SetAllowed(int64_t allowed, bool warm_up) {
  const std::lock_guard lock(mutex_);
  control_.warm_up = warm_up;
  allowed_ = std::max(allowed_, std::min(allowed, experiment_.total_env_steps));
  DistributeCredit();
}

// What is allowed and neither accepted nor granted goes evenly to the living sessions. Credit never shrinks, so the
// sum of accepted and granted can never pass `allowed_`, and a run ends exactly at its total.
void Coordinator::DistributeCredit() {
  int64_t committed = retired_accepted_;
  for (const auto& [id, actor] : fleet_.actors()) committed += std::max(actor.credit, actor.accepted);
  int64_t free = allowed_ - committed;
  auto left = static_cast<int64_t>(fleet_.actors().size());
  for (auto& [id, actor] : fleet_.actors()) {
    const int64_t share = free / left--;
    if (share <= 0) continue;
    actor.credit = std::max(actor.credit, actor.accepted) + share;
    free -= share;
    dirty_ = true;
  }
}

Harvest Coordinator::Take(Duration timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [this] { return stopped_ || !harvest_.segments.empty(); });
  Harvest taken;
  std::swap(taken, harvest_);
  return taken;
}

void Coordinator::Evaluate(const EvaluationRequest& request, std::span<const float> parameters) {
  const std::lock_guard lock(mutex_);
  PendingEvaluation evaluation;
  evaluation.request = request;
  evaluations_.push_back(std::move(evaluation));
  KeepPolicy(request.version, parameters);
  if (evaluations_.size() == 1) NextEvaluation();
}

// Starts the front of the queue: a fresh id, all results missing, contiguous shares over the actors.
void Coordinator::NextEvaluation() {
  control_.evaluation_id = 0;
  if (!evaluations_.empty()) {
    PendingEvaluation& evaluation = evaluations_.front();
    evaluation.id = next_evaluation_id_++;
    evaluation.missing = evaluation.request.num_starts;
    evaluation.results.assign(static_cast<size_t>(evaluation.missing), std::nullopt);
    control_.evaluation_id = evaluation.id;
    control_.evaluation_version = evaluation.request.version;
    control_.evaluation_set = evaluation.request.set;
  }
  dirty_ = true;
  SendControl(Clock::now());
}

std::vector<EvaluationReport> Coordinator::TakeEvaluations(bool wait) {
  std::unique_lock lock(mutex_);
  if (wait) changed_.wait(lock, [this] { return stopped_ || evaluations_.empty(); });
  std::vector<EvaluationReport> taken;
  taken.swap(reports_);
  return taken;
}

// An actor that was silent for longer than the limit loses its vehicles to the others; the last one stays, since
// nobody could take over.
void Coordinator::GiveUpSilentActors(TimePoint now) {
  if (control_.phase != Control::Phase::kRunning) return;
  const auto limit =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(experiment_.lockstep.actor_timeout_s));
  for (const auto& [id, actor] : fleet_.actors()) {
    if (now - actor.last_heard <= limit || fleet_.actors().size() < 2) continue;
    log::Error("actor {} was silent for {} s: its vehicles go to the others", id, experiment_.lockstep.actor_timeout_s);
    retired_accepted_ += actor.accepted;
    for (const int64_t session : fleet_.Reassign(id)) {
      bus_->Publish(Plane::kControl, kWelcomeChannel, fleet_.Assignment(*fleet_.Find(session)));
    }
    if (!evaluations_.empty()) NextEvaluation();
    return;  // the map has changed; the next silent one is found 5 ms later
  }
}

bool Coordinator::WaitingForActors() const {
  if (control_.phase != Control::Phase::kRunning) return false;
  return !evaluations_.empty() || !control_.lockstep || round_steps_missing_ > 0;
}

void Coordinator::AnnounceIfDue(TimePoint now) {
  if (fleet_.actors().empty()) return;
  const Duration since = now - last_control_;
  if ((dirty_ && since >= kMinControlGap) || (WaitingForActors() && since >= kReannounce) || since >= kIdleAnnounce) {
    SendControl(now);
  }
}

void Coordinator::SendControl(TimePoint now) {
  control_.utime = 0;
  control_.actors.clear();
  const auto n = static_cast<int>(fleet_.actors().size());
  const int starts = evaluations_.empty() ? 0 : evaluations_.front().request.num_starts;
  const int64_t window = bus_->receive_buffer_bytes() / 2 / std::max(1, n);
  int rank = 0;
  for (const auto& [id, actor] : fleet_.actors()) {
    const int first = starts * rank / n;
    const int end = starts * (rank + 1) / n;
    control_.actors.push_back(
        {id, actor.session, actor.stream.received(), 0, actor.credit, window, actor.echo_utime, first, end - first});
    ++rank;
  }
  bus_->Publish(Plane::kControl, kControlChannel, control_);
  last_control_ = now;
  dirty_ = false;
}

CoordinatorCounters Coordinator::counters() const {
  const std::lock_guard lock(mutex_);
  CoordinatorCounters counters = counters_;
  counters.refused += bus_->stats().refused;
  counters.num_actors = static_cast<int>(fleet_.actors().size());
  counters.disturbed = fleet_.disturbed();
  return counters;
}

TableInfo Coordinator::table_info() const {
  const std::lock_guard lock(mutex_);
  return table_info_;
}

}  // namespace cairn::learner
