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
constexpr auto kWelcomeResendGap = milliseconds(50);
constexpr int kStateOverhead = 128;  // bytes of a message that are not state

}  // namespace

Coordinator::Coordinator(Bus* bus, const Experiment& experiment, uint64_t experiment_hash, int num_actors)
    : bus_(bus),
      experiment_(experiment),
      observation_size_(ObservationSize(experiment)),
      tables_(bus, experiment_hash),
      fleet_(num_actors, experiment.num_vehicles, experiment_hash, observation_size_, GitRevision()),
      control_{.incarnation = RandomId()},
      policies_(bus, control_.incarnation),
      rounds_(experiment.num_vehicles) {
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
    if (now >= stop_at_ && !stopped_) {
      stopped_ = true;
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

void Coordinator::StopWithin(Duration time) {
  const std::lock_guard lock(mutex_);
  stop_at_ = Clock::now() + time;
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
  ActorRecord* actor = fleet_.Find(hello.session);
  if (welcome.status == Welcome::Status::kAccepted && actor != nullptr) {
    SendWelcome(actor, Clock::now());
  } else {
    bus_->Publish(Plane::kControl, kWelcomeChannel, welcome);
  }
}

// The assignment, and behind it the states that its vehicles go on with.
void Coordinator::SendWelcome(ActorRecord* actor, TimePoint now) {
  actor->welcomed = now;
  const Welcome welcome = fleet_.Assignment(*actor);
  bus_->Publish(Plane::kControl, kWelcomeChannel, welcome);
  const int max_bytes = MaxMessageBytes(experiment_.transport.ttl) - kStateOverhead;
  for (const int32_t vehicle : welcome.vehicle) {
    const VehicleRecord& record = fleet_.vehicles()[static_cast<size_t>(vehicle)];
    for (VehicleStatePiece& piece : SplitState(vehicle, record.steps, record.environment, max_bytes)) {
      const AssignedState state{control_.incarnation, actor->session, actor->assignment, std::move(piece)};
      bus_->Publish(Plane::kControl, kStateChannel, state);
    }
  }
}

void Coordinator::OnStatus(const ActorStatus& status) {
  const std::lock_guard lock(mutex_);
  ActorRecord* actor = fleet_.Find(status.session);
  if (actor == nullptr) return;
  const TimePoint now = Clock::now();
  actor->last_heard = now;
  if (status.assignment < actor->assignment && now - actor->welcomed > kWelcomeResendGap) SendWelcome(actor, now);
  policies_.Resend(status.wanted_policy_version, now);
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
  AcceptStates(*actor, experience);
  AcceptSegments(actor, experience);
  changed_.notify_all();
}

void Coordinator::AcceptSegments(ActorRecord* actor, const Experience& experience) {
  for (const Segment& segment : experience.segments) {
    switch (fleet_.Judge(*actor, segment)) {
      case Fleet::Verdict::kSound:
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
    if (segment.table_hash != control_.table_hash || segment.policy_incarnation != control_.incarnation) {
      Refuse(*actor, segment);
      continue;
    }
    if (!control_.lockstep) {
      harvest_.segments.push_back(segment);
    } else if (!rounds_.Add(segment, fleet_.vehicles()[static_cast<size_t>(segment.vehicle)].steps)) {
      Refuse(*actor, segment);
      continue;
    }
    fleet_.Accept(segment);
    if (control_.lockstep) {
      VehicleState passed = fleet_.vehicles()[static_cast<size_t>(segment.vehicle)];
      if (const Bytes* state = states_.Find(segment.vehicle, passed.steps)) passed.environment = *state;
      rounds_.Passed(segment.vehicle, passed);
    }
    actor->accepted += segment.num_steps();
    counters_.transitions_accepted += segment.num_steps();
    counters_.policy_lag_sum += static_cast<double>(control_.policy_version - segment.policy_version);
    ++counters_.policy_lag_count;
  }
}

void Coordinator::AcceptStates(const ActorRecord& actor, const Experience& experience) {
  for (const VehicleStatePiece& piece : experience.states) {
    const bool known = piece.vehicle >= 0 && piece.vehicle < experiment_.num_vehicles;
    if (known && fleet_.vehicles()[static_cast<size_t>(piece.vehicle)].owner == actor.actor_id) states_.Add(piece);
  }
}

void Coordinator::Refuse(const ActorRecord& actor, const Segment& segment) {
  ++counters_.refused;
  log::Warning(
      "actor {}: {} steps of vehicle {} refused: table {:016x}, policy {:016x} version {}; in force are table {:016x}, "
      "policy {:016x} version {}, {} steps missing in the open rounds",
      actor.actor_id, segment.num_steps(), segment.vehicle, segment.table_hash, segment.policy_incarnation,
      segment.policy_version, control_.table_hash, control_.incarnation, control_.policy_version, rounds_.missing());
}

void Coordinator::AcceptEpisodes(const ActorRecord& actor, const Experience& experience) {
  for (const EpisodeResult& result : experience.episodes) {
    if (result.set != StartSet::kTraining) {
      const int64_t running = evaluations_.id();
      evaluations_.Accept(result);
      if (evaluations_.id() != running) AnnounceEvaluation();
    } else if (result.vehicle >= 0 && result.vehicle < experiment_.num_vehicles) {
      if (result.outcome == Outcome::kDiverged) fleet_.CloseDiverged(actor, result);
      if (control_.lockstep) {
        rounds_.Add(result, fleet_.vehicles()[static_cast<size_t>(result.vehicle)].steps);
      } else {
        harvest_.episodes.push_back(result);
      }
    }
  }
}

// --- what goes out ---------------------------------------------------------------------------------------------------

void Coordinator::PublishPolicy(int64_t version, std::span<const float> parameters) {
  const std::lock_guard lock(mutex_);
  control_.policy_version = version;
  KeepPolicy(version, parameters);
  dirty_ = true;
}

void Coordinator::KeepPolicy(int64_t version, std::span<const float> parameters) {
  policies_.Add(version, parameters);
  policies_.DropUnused([this](int64_t v) {
    return v == control_.policy_version || evaluations_.Uses(v) ||
           std::any_of(control_.rounds.begin(), control_.rounds.end(),
                       [v](const Control::Round& r) { return r.policy_version == v; });
  });
}

int64_t Coordinator::GrantRound(int steps, int extra, bool warm_up, bool save) {
  const std::lock_guard lock(mutex_);
  const int64_t granted = rounds_.Grant(steps, extra, control_.policy_version, warm_up, save);
  control_.rounds = rounds_.granted();
  SendControl(Clock::now());
  return granted;
}

bool Coordinator::rounds_level() const {
  const std::lock_guard lock(mutex_);
  return rounds_.level();
}

std::optional<Harvest> Coordinator::WaitRound() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return stopped_ || rounds_.front_complete(); });
  if (stopped_) return std::nullopt;
  Harvest round = rounds_.TakeFront();
  control_.rounds = rounds_.granted();
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
  evaluations_.Add(request);
  KeepPolicy(request.version, parameters);
  AnnounceEvaluation();
}

void Coordinator::AnnounceEvaluation() {
  control_.evaluation_id = evaluations_.id();
  if (!evaluations_.empty()) {
    control_.evaluation_version = evaluations_.running().version;
    control_.evaluation_set = evaluations_.running().set;
  }
  SendControl(Clock::now());
}

std::vector<EvaluationReport> Coordinator::TakeEvaluations(bool wait) {
  std::unique_lock lock(mutex_);
  if (wait) changed_.wait(lock, [this] { return stopped_ || evaluations_.empty(); });
  // Counted with what the caller makes of them: a checkpoint in between must not count them twice.
  std::vector<EvaluationReport> reports = evaluations_.TakeReports();
  for (const EvaluationReport& report : reports) {
    for (const EpisodeResult& result : report.results) counters_.eval_steps += result.steps;
  }
  return reports;
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
      SendWelcome(fleet_.Find(session), now);
    }
    evaluations_.Restart();
    AnnounceEvaluation();
    return;  // the map has changed; the next silent one is found 5 ms later
  }
}

bool Coordinator::WaitingForActors() const {
  if (control_.phase != Control::Phase::kRunning) return false;
  return !evaluations_.empty() || !control_.lockstep || rounds_.missing() > 0;
}

void Coordinator::AnnounceIfDue(TimePoint now) {
  if (fleet_.actors().empty()) return;
  const Duration since = now - last_control_;
  if ((dirty_ && since >= kMinControlGap) || (WaitingForActors() && since >= kReannounce) || since >= kIdleAnnounce) {
    SendControl(now);
  }
}

void Coordinator::SendControl(TimePoint now) {
  ++control_.number;
  control_.actors.clear();
  const auto n = static_cast<int>(fleet_.actors().size());
  const int64_t window = bus_->receive_buffer_bytes() / 2 / std::max(1, n);
  int rank = 0;
  for (const auto& [id, actor] : fleet_.actors()) {
    const auto [first, end] = evaluations_.Share(rank, n);
    control_.actors.push_back(
        {id, actor.session, actor.stream.received(), 0, actor.credit, window, actor.echo_utime, first, end - first});
    ++rank;
  }
  bus_->Publish(Plane::kControl, kControlChannel, control_);
  last_control_ = now;
  dirty_ = false;
}

CoordinatorState Coordinator::State(const Harvest& harvest) const {
  CoordinatorState state;
  state.counters = counters();
  const std::lock_guard lock(mutex_);
  state.vehicles = harvest.vehicles;
  if (!control_.lockstep) state.vehicles.assign(fleet_.vehicles().begin(), fleet_.vehicles().end());
  state.rounds = rounds_.taken();
  state.granted = rounds_.open();
  for (RoundState& round : state.granted) round.policy.parameters = policies_.Find(round.policy.version);
  return state;
}

void Coordinator::Restore(const CoordinatorState& state, int64_t env_steps) {
  const std::lock_guard lock(mutex_);
  counters_ = state.counters;
  counters_.transitions_accepted = env_steps;
  fleet_.Restore(state);
  std::vector<int64_t> steps;
  for (const VehicleRecord& vehicle : fleet_.vehicles()) steps.push_back(vehicle.steps);
  rounds_.Restore(state.rounds, std::move(steps));
  retired_accepted_ = env_steps;
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
