#include "learner/coordinator.h"

#include <algorithm>
#include <utility>

#include "common/core/check.h"
#include "common/core/hash.h"
#include "common/core/log.h"
#include "common/core/version.h"

namespace cairn::learner {
namespace {

using std::chrono::milliseconds;

constexpr auto kMinControlGap = milliseconds(5);  // 200 Hz at most
constexpr auto kReannounce = milliseconds(20);    // until acted on
constexpr int kCreditSteps = 10;                  // of each vehicle
constexpr int64_t kCreditBurst = 64;
constexpr auto kCreditPatience = milliseconds(50);
constexpr auto kPublishInterval = milliseconds(20);
constexpr auto kIntervalPerActor = std::chrono::microseconds(1600);  // ASYNC: of what wakes up all of them
constexpr auto kLongestInterval = milliseconds(500);  // of frames: an actor that misses itself in them starts over
constexpr auto kIdleAnnounce = milliseconds(1000);
constexpr auto kWelcomeResendGap = milliseconds(50);
constexpr auto kSearchAnnounce = milliseconds(50);  // while nobody has joined
constexpr auto kBrokerGrace = milliseconds(3000);
constexpr int kStateOverhead = 128;  // bytes of a message that are not state

CreditLedger::Amounts Credit(const Experiment& e) {
  const int64_t steps = int64_t{kCreditSteps} * e.num_vehicles;
  return {std::min<int64_t>(steps, e.async.error_buffer / 3), e.async.error_buffer / 2, kCreditBurst};
}

int64_t NumBytes(const Experience& experience) {
  size_t floats = 0;
  for (const Segment& s : experience.segments) floats += s.observations.size() + s.actions.size() + s.rewards.size();
  size_t bytes = floats * sizeof(float) + 64 * (1 + experience.segments.size() + experience.episodes.size());
  for (const VehicleStatePiece& piece : experience.states) bytes += piece.data.size();
  return static_cast<int64_t>(bytes);
}

void AddStreamCounters(const ActorRecord& actor, CoordinatorCounters* counters) {
  counters->messages_sent += actor.status.sent;
  counters->messages_resent += actor.status.resent;
  counters->credit_wait_s += 1e-6 * static_cast<double>(actor.status.wait_us);
}

}  // namespace

Coordinator::Coordinator(Bus* bus, const Experiment& experiment, uint64_t experiment_hash, int num_actors,
                         int64_t incarnation)
    : bus_(bus),
      experiment_(experiment),
      observation_size_(ObservationSize(experiment)),
      tables_(bus, experiment_hash),
      fleet_(num_actors, experiment.num_vehicles, experiment_hash, observation_size_, GitRevision()),
      control_{.incarnation = incarnation},
      policies_(bus, incarnation),
      rounds_(experiment.num_vehicles),
      evaluations_(incarnation),
      intake_(experiment, control_, &fleet_, &rounds_, &evaluations_, &counters_),
      writer_(bus),
      credit_(experiment.total_env_steps, Credit(experiment)) {
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
                              [this](Experience&& e, const FrameInfo&) { OnExperience(std::move(e)); });
  bus_->CheckPlanes();
  tables_.RequestInfo();
  started_ = Clock::now();
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void Coordinator::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    bus_->Poll(kMinControlGap);
    const TimePoint now = Clock::now();
    tables_.Poll(now);
    const std::lock_guard lock(mutex_);
    // Once for all messages that had come: waking the update thread for each costs more than taking it in.
    if (std::exchange(news_, false)) changed_.notify_all();
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
    // Nobody can be heard without a broker, and nobody is silent for that; who comes back has time to find it again.
    if (bus_->outage()) {
      for (auto& [id, actor] : fleet_.actors()) actor.last_heard = now + kBrokerGrace;
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

bool Coordinator::FleetReady(TimePoint now) const {
  if (control_.table_hash == 0) return false;
  if (fleet_.complete()) return true;
  return control_.incarnation > 1 && fleet_.num_joined() > 0 &&
         now - started_ > std::chrono::duration<double>(experiment_.lockstep.actor_timeout_s);
}

bool Coordinator::WaitForFleet() {
  std::unique_lock lock(mutex_);
  while (!stopped_ && !FleetReady(Clock::now())) changed_.wait_for(lock, milliseconds(100));
  if (stopped_) return false;
  control_.phase = Control::Phase::kRunning;
  dirty_ = true;
  for (const auto& [id, actor] : fleet_.actors()) {
    if (!actor.joined) credit_.Retire(actor.accepted);
  }
  SendWelcomes(fleet_.Start());
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

// A hello that names another incarnation is old: it may be refused, but nobody joins by it. Nor does anybody before the
// table is known, since a session that goes on sends at once what must be judged by it.
void Coordinator::OnHello(const Hello& hello) {
  const std::lock_guard lock(mutex_);
  if (hello.incarnation != control_.incarnation && hello.incarnation != 0) return;
  if ((hello.incarnation == 0 || control_.table_hash == 0) && fleet_.Compatible(hello)) return;
  const auto holder = fleet_.actors().find(hello.actor_id);
  const bool known = holder != fleet_.actors().end();
  ActorRecord held;
  if (known) held = holder->second;
  const Welcome welcome = fleet_.Join(hello, Clock::now());
  ActorRecord* actor = fleet_.Find(hello.session);
  if (welcome.status != Welcome::Status::kAccepted || actor == nullptr) {
    ++counters_.refused;
    log::Warning("actor {} refused: {}", hello.actor_id, welcome.reason);
    bus_->Publish(Plane::kControl, kWelcomeChannel, welcome);
    return;
  }
  const bool replaces = known && held.session != hello.session;
  if (replaces) Retire(held);
  if (replaces || !known || !held.joined) {
    if (!known && fleet_.started()) SendWelcomes(fleet_.Share(hello.actor_id));
    SharesChanged();
    dirty_ = true;
    changed_.notify_all();
  }
  SendWelcome(actor, Clock::now());
}

// The evaluation under way is shared out anew among those who are here.
void Coordinator::SharesChanged() {
  if (!fleet_.started()) return;
  evaluations_.Restart();
  AnnounceEvaluation();
}

void Coordinator::SendWelcomes(const std::vector<int64_t>& sessions) {
  for (const int64_t session : sessions) SendWelcome(fleet_.Find(session), Clock::now());
}

// The assignment, and behind it the states that its vehicles go on with.
void Coordinator::SendWelcome(ActorRecord* actor, TimePoint now) {
  actor->welcomed = now;
  const Welcome welcome = fleet_.Assignment(*actor);
  bus_->Publish(Plane::kControl, kWelcomeChannel, welcome);
  const int max_bytes = bus_->max_message_bytes() - kStateOverhead;
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
  actor->status = status;
  actor->stream.Announce(status.last_sequence);
  dirty_ = dirty_ || !actor->stream.Gaps(1).empty();
  if (status.leaving) SendWelcomes(fleet_.Leave(actor->actor_id));
  SendWelcomes(fleet_.Settle());
  // Before the run has started nobody can act on an assignment.
  const bool behind = control_.phase == Control::Phase::kRunning && status.assignment < actor->assignment;
  if (behind && now - actor->welcomed > kWelcomeResendGap) SendWelcome(actor, now);
  policies_.Resend(status.wanted_policy_version, now);
  if (fleet_.Gone(*actor)) {
    log::Info("actor {} left after {} transitions", actor->actor_id, actor->accepted);
    Retire(*actor);
    fleet_.Forget(status.actor_id);
    SharesChanged();
    dirty_ = true;
  }
}

void Coordinator::OnExperience(Experience&& experience) {
  const std::lock_guard lock(mutex_);
  ActorRecord* actor = fleet_.Find(experience.session);
  if (actor == nullptr || experience.observation_size != observation_size_ ||
      experience.action_size != experiment_.vehicle.action_size()) {
    ++counters_.refused;
    return;
  }
  actor->last_heard = Clock::now();
  actor->echo_us = experience.send_us;
  actor->unannounced_bytes += NumBytes(experience);
  using Verdict = ReliableReceiver<Experience>::Verdict;
  const int64_t sequence = experience.sequence;
  if (actor->stream.Accept(sequence, std::move(experience)) == Verdict::kDuplicate) ++counters_.stream_duplicates;
  const int64_t running = evaluations_.id();
  while (std::optional<Experience> next = actor->stream.Take()) {
    intake_.Accept(actor, std::move(*next));
    news_ = true;
  }
  if (evaluations_.id() != running) AnnounceEvaluation();
  // In ASYNC an acknowledgement can wait for the next frame, which comes soon, while nothing waits for it.
  dirty_ = dirty_ || control_.lockstep || 2 * actor->unannounced_bytes > writer_.Window(fleet_) ||
           !actor->stream.Gaps(1).empty();
}

// --- what goes out ---------------------------------------------------------------------------------------------------

void Coordinator::PublishPolicy(int64_t version, std::span<const float> parameters) {
  const std::lock_guard lock(mutex_);
  control_.policy_version = version;
  KeepPolicy(version, parameters);
  dirty_ = dirty_ || control_.lockstep;  // in ASYNC actors use what is complete; whoever missed it hears of it soon
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

Duration Coordinator::publish_interval() const {
  const std::lock_guard lock(mutex_);
  return Interval(kPublishInterval, Duration::max());
}

bool Coordinator::rounds_level() const {
  const std::lock_guard lock(mutex_);
  return rounds_.level();
}

int Coordinator::open_rounds() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(control_.rounds.size());
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
  credit_.Allow(allowed);
  const Duration interval = Interval(Duration::zero(), kLongestInterval);
  dirty_ = credit_.Distribute(&fleet_, interval, kCreditPatience, Clock::now()) || dirty_;
}

Harvest Coordinator::Take(Duration timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [this] { return stopped_ || !intake_.harvest().segments.empty(); });
  Harvest taken;
  std::swap(taken, intake_.harvest());
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

// What a session that is gone leaves in the books.
void Coordinator::Retire(const ActorRecord& actor) {
  credit_.Retire(actor.accepted);
  AddStreamCounters(actor, &counters_);
}

// An actor that was silent for longer than the limit loses its vehicles to the others; the last one stays, since
// nobody could take over.
void Coordinator::GiveUpSilentActors(TimePoint now) {
  if (control_.phase != Control::Phase::kRunning) return;
  const auto limit =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(experiment_.lockstep.actor_timeout_s));
  for (const auto& [id, actor] : fleet_.actors()) {
    if (now - actor.last_heard <= limit || !fleet_.HasOther(id)) continue;
    log::Error("actor {} was silent for {} s: its vehicles go to the others", id, experiment_.lockstep.actor_timeout_s);
    Retire(actor);
    SendWelcomes(fleet_.Reassign(id));
    SharesChanged();
    return;  // the map has changed; the next silent one is found 5 ms later
  }
}

// ASYNC: the longer the more actors there are, so that together they wake up equally often.
Duration Coordinator::Interval(Duration least, Duration most) const {
  return std::clamp<Duration>(fleet_.num_joined() * kIntervalPerActor, least, most);
}

bool Coordinator::WaitingForActors() const {
  if (control_.phase != Control::Phase::kRunning) return false;
  return !evaluations_.empty() || !control_.lockstep || rounds_.missing() > 0;
}

void Coordinator::AnnounceIfDue(TimePoint now) {
  const Duration since = now - last_control_;
  if (fleet_.num_joined() == 0 && since >= kSearchAnnounce) return SendControl(now);
  const Duration again = control_.lockstep ? kReannounce : Interval(kReannounce, kLongestInterval);
  if ((dirty_ && since >= kMinControlGap) || (WaitingForActors() && since >= again) || since >= kIdleAnnounce) {
    SendControl(now);
  }
}

void Coordinator::SendControl(TimePoint now) {
  writer_.Send(evaluations_, keeps_, &fleet_, &control_);
  last_control_ = now;
  dirty_ = false;
}

CoordinatorState Coordinator::State(Harvest* harvest) {
  const std::lock_guard lock(mutex_);
  CoordinatorState state;
  state.counters = Counters();
  if (!control_.lockstep) {
    std::swap(*harvest, intake_.harvest());
    state.vehicles.assign(fleet_.vehicles().begin(), fleet_.vehicles().end());
    for (const auto& [id, actor] : fleet_.actors()) {
      state.sessions.push_back({id, actor.session, actor.generation, actor.assignment, actor.stream.received(),
                                actor.accepted, actor.credit});
    }
    return state;
  }
  state.vehicles = harvest->vehicles;
  // Of a run that was trained from a log: no vehicle has made a step.
  if (state.vehicles.empty()) state.vehicles.assign(fleet_.vehicles().begin(), fleet_.vehicles().end());
  state.rounds = rounds_.taken();
  state.granted = rounds_.open();
  for (RoundState& round : state.granted) round.policy.parameters = policies_.Find(round.policy.version);
  return state;
}

void Coordinator::SetDurable(const std::vector<SessionState>& sessions) {
  const std::lock_guard lock(mutex_);
  for (const SessionState& session : sessions) {
    ActorRecord* actor = fleet_.Find(session.session);
    if (actor != nullptr) actor->durable = std::max(actor->durable, session.received);
  }
}

void Coordinator::Restore(const CoordinatorState& state, int64_t env_steps) {
  const std::lock_guard lock(mutex_);
  counters_ = state.counters;
  counters_.transitions_accepted = env_steps;
  fleet_.Restore(state);
  std::vector<int64_t> steps;
  for (const VehicleRecord& vehicle : fleet_.vehicles()) steps.push_back(vehicle.steps);
  rounds_.Restore(state.rounds, std::move(steps));
  int64_t gone = env_steps;
  for (const auto& [id, actor] : fleet_.actors()) gone -= actor.accepted;
  credit_.Retire(gone);
}

CoordinatorCounters Coordinator::counters() const {
  const std::lock_guard lock(mutex_);
  return Counters();
}

CoordinatorCounters Coordinator::Counters() const {
  CoordinatorCounters counters = counters_;
  counters.refused += bus_->stats().refused;
  counters.num_actors = fleet_.num_joined();
  double latency_us = 0;
  for (const auto& [id, actor] : fleet_.actors()) {
    AddStreamCounters(actor, &counters);
    latency_us += static_cast<double>(actor.status.round_trip_us);
  }
  counters.stream_latency_s = 1e-6 * latency_us / std::max<double>(1, static_cast<double>(fleet_.actors().size()));
  counters.disturbed = fleet_.disturbed();
  return counters;
}

TableInfo Coordinator::table_info() const {
  const std::lock_guard lock(mutex_);
  return table_info_;
}

}  // namespace cairn::learner
