#include "actors/actor.h"

#include <algorithm>
#include <numeric>

#include "actors/controllers/policy_controller.h"
#include "common/bus/frame.h"
#include "common/core/check.h"
#include "common/core/log.h"
#include "common/core/version.h"
#include "common/nn/gemm.h"
#include "common/nn/policy_shape.h"

namespace cairn::actors {
namespace {

using std::chrono::milliseconds;

constexpr auto kHelloInterval = milliseconds(100);
constexpr auto kWaitingStatus = milliseconds(20);
constexpr auto kQuietStatus = milliseconds(250);
constexpr auto kIdleStatus = milliseconds(1000);
constexpr auto kShortWait = milliseconds(5);
constexpr auto kFlushInterval = milliseconds(50);       // ASYNC: no transition is older than this when it leaves
constexpr auto kLeastFlushInterval = milliseconds(10);  // ASYNC: but for the end of credit
constexpr int kAsyncSegmentSteps = 10;
constexpr auto kRollTime = milliseconds(1);             // ASYNC: without looking at what came in
constexpr auto kEvaluateTime = milliseconds(20);        // the same of an evaluation
constexpr auto kIdTakenPatience = milliseconds(5000);   // a dead holder is forgotten after three seconds
constexpr auto kUnlistedPatience = milliseconds(1500);  // frames without this actor, from a learner that it has joined
constexpr auto kLeavePatience = milliseconds(3000);

}  // namespace

Actor::Actor(Bus* bus, const Experiment& experiment, const ActorIdentity& identity)
    : bus_(bus),
      experiment_(experiment),
      identity_(identity),
      observation_size_(ObservationSize(experiment)),
      action_size_(experiment.vehicle.action_size()),
      scene_(std::make_shared<Scene>(experiment)),
      tables_(bus, identity.experiment_hash),
      goal_tables_(bus, experiment, identity.experiment_hash),
      course_(std::make_shared<Course>(scene_, [this](const WorldGoal& goal) { return goal_tables_.Find(goal); })),
      policies_(static_cast<int>(MakePolicyShape(experiment).num_parameters())),
      policy_(MakePolicyShape(experiment), std::max(64, experiment.num_vehicles)),
      rollout_(course_),
      stream_([bus, channel = ExperienceChannel(identity.actor_id)](const Bytes& message) {
        bus->PublishBytes(Plane::kExperience, channel, message);
      }),
      audit_(fmt::format("actor-{:04}-{:02}", identity.actor_id, identity.generation)) {}

void Actor::Subscribe() {
  bus_->Subscribe<Welcome>(Plane::kControl, kWelcomeChannel,
                           [this](const Welcome& welcome, const FrameInfo&) { OnWelcome(welcome); });
  bus_->Subscribe<Control>(Plane::kControl, kControlChannel,
                           [this](Control&& control, const FrameInfo&) { OnControl(std::move(control)); });
  bus_->Subscribe<PolicyChunk>(Plane::kControl, kPolicyChannel,
                               [this](const PolicyChunk& chunk, const FrameInfo&) { policies_.Add(chunk); });
  bus_->Subscribe<AssignedState>(Plane::kControl, kStateChannel,
                                 [this](const AssignedState& state, const FrameInfo&) { OnState(state); });
  bus_->CheckPlanes();
}

Actor::End Actor::Run() {
  Subscribe();
  Duration wait = Duration::zero();
  TimePoint waiting_since = Clock::now();
  while (!finished() && !Left(Clock::now())) {
    bus_->Poll(wait);
    if (!refusal_.empty()) ThrowUsageError("the learner refused actor {}: {}", identity_.actor_id, refusal_);
    const TimePoint start = Clock::now();
    CheckMembership(start);
    if (start_over_) return End::kStartOver;
    if (wait != Duration::zero() && joined_) waited_ += start - waiting_since;
    tables_.Poll(start);
    goal_tables_.Poll(start);
    stream_.Poll(start);
    const bool worked =
        Join(start) && ReceiveTable() && (Evaluate() || (control_->lockstep ? RollRounds() : RollCredit()));
    const TimePoint now = Clock::now();
    if (worked) busy_s_ += std::chrono::duration<double>(now - start).count();
    SendStatus(now, worked ? Duration(kIdleStatus) : StatusInterval());
    SendTelemetry(now);
    wait = worked ? Duration::zero() : Wait(now);
    waiting_since = now;
  }
  return End::kFinished;
}

// While the learner may have to act on it, often; else often enough not to be called silent. In ASYNC
// acknowledgements take their time, and what is lost at the end of the stream is probed for.
Duration Actor::StatusInterval() const {
  const bool starting = control_ && control_->phase == Control::Phase::kStarting;
  if ((!running() && !starting) || leaving_ || wanted_policy_version_ >= 0) return kWaitingStatus;
  if (!stream_.idle() && control_->lockstep) return kWaitingStatus;
  const auto silence = std::chrono::duration<double>(experiment_.lockstep.actor_timeout_s / 4);
  return std::min<Duration>(kQuietStatus, std::chrono::duration_cast<Duration>(silence));
}

void Actor::RequestLeave() {
  leaving_ = true;
  bus_->Wake();
}

// Until something is due here; what comes in and RequestLeave end the wait.
Duration Actor::Wait(TimePoint now) const {
  if (!running() || leaving_ || goal_tables_.waiting()) return kShortWait;
  // A status that nobody waits for goes out when something else has ended the wait, if that is soon enough.
  const Duration status = StatusInterval();
  const TimePoint due =
      std::min(last_status_ + (status > kWaitingStatus ? status * 3 / 2 : status), stream_.next_probe());
  return std::max<Duration>(due - now, milliseconds(1));
}

// Nothing is left here, and the learner knows it; or nobody answers.
bool Actor::Left(TimePoint now) {
  if (!leaving_) return false;
  leave_deadline_ = std::min(leave_deadline_, now + kLeavePatience);
  if (!joined_ || now > leave_deadline_) return true;
  const bool empty = assignment_done_ >= 0 && rollout_.num_vehicles() == 0 && stream_.idle();
  return empty && now - me_seen_ > kWaitingStatus * 5;  // it is listed until the learner has forgotten it
}

// A learner that gave this actor up while it hung goes on without it.
void Actor::CheckMembership(TimePoint now) {
  const bool heard = control_ && control_->number > me_number_ + 2;
  if (joined_ && !leaving_ && heard && now - me_seen_ > kUnlistedPatience) start_over_ = true;
}

// --- what comes in ---------------------------------------------------------------------------------------------------

void Actor::OnWelcome(const Welcome& welcome) {
  if (welcome.session != bus_->config().session || welcome.incarnation < incarnation_) return;
  switch (welcome.status) {
    case Welcome::Status::kRefused:
      refusal_ = welcome.reason;
      return;
    case Welcome::Status::kUnknown:
      start_over_ = true;
      return;
    case Welcome::Status::kIdTaken:
      if (id_taken_since_ == TimePoint{}) id_taken_since_ = Clock::now();
      if (Clock::now() - id_taken_since_ > kIdTakenPatience) refusal_ = welcome.reason;
      return;
    case Welcome::Status::kAccepted:
      break;
  }
  if (welcome.incarnation > incarnation_) OnNewLearner(welcome.incarnation);
  if (welcome_ && !joined_) return GoOn(welcome);
  if (welcome_ && welcome.assignment <= welcome_->assignment) return;
  if (!joined_) me_seen_ = Clock::now();
  welcome_ = welcome;
  joined_ = true;
  states_.Clear();
}

// ASYNC: the learner that follows the one this session began with has it in its checkpoint, as it was then.
void Actor::GoOn(const Welcome& welcome) {
  std::vector<int32_t> vehicles;
  for (int i = 0; i < rollout_.num_vehicles(); ++i) vehicles.push_back(rollout_.vehicle(i));
  SendExperience();  // what was made under the earlier learner's policy
  start_over_ = welcome.vehicle != vehicles || !stream_.Rewind(welcome.received, Clock::now());
  if (start_over_) return;
  log::Info("going on with learner {} from message {}", welcome.incarnation, welcome.received);
  welcome_ = welcome;
  assignment_done_ = welcome.assignment;
  joined_ = true;
  me_seen_ = Clock::now();
}

void Actor::OnState(const AssignedState& state) {
  if (!welcome_ || state.session != welcome_->session || state.assignment != welcome_->assignment) return;
  if (state.assignment > assignment_done_) states_.Add(state.piece);
}

// A learner was restarted. What its rounds, evaluations and policies are called begins anew. In LOCKSTEP it has the
// vehicles' states, and those here are worth nothing.
void Actor::OnNewLearner(int64_t incarnation) {
  start_over_ = welcome_ && experiment_.schedule == Schedule::kLockstep;
  incarnation_ = incarnation;
  control_.reset();
  me_.reset();
  me_number_ = 0;
  joined_ = false;
  policies_.SetIncarnation(incarnation);
  wanted_policy_version_ = -1;
  evaluation_done_ = 0;
  evaluation_.reset();
  evaluation_results_.clear();
}

void Actor::OnControl(Control control) {
  if (control.incarnation < incarnation_) return;
  if (control.incarnation > incarnation_) OnNewLearner(control.incarnation);
  const TimePoint now = Clock::now();
  for (const Control::Actor& actor : control.actors) {
    if (actor.session != bus_->config().session) continue;
    me_seen_ = now;
    if (control.number <= me_number_ || !joined_) continue;
    me_ = actor;
    me_number_ = control.number;
    me_evaluation_ = control.evaluation_id;
    stream_.Acknowledge({actor.received, actor.durable, actor.window, actor.echo_us, actor.gaps}, now);
  }
  // Datagrams of one sender may overtake each other; only newer state counts.
  if (control_ && control.number <= control_->number) return;
  control.actors.clear();
  control_ = std::move(control);
  if (control_->evaluation_id != 0) policies_.Pin(control_->evaluation_version);
  tables_.Want(control_->roadmap_hash, control_->table_hash);
}

// --- what it does ----------------------------------------------------------------------------------------------------

bool Actor::Join(TimePoint now) {
  if (joined_) return control_.has_value();
  if (now >= next_hello_) {
    next_hello_ = now + kHelloInterval;
    Hello hello;
    hello.session = bus_->config().session;
    hello.experiment_hash = identity_.experiment_hash;
    hello.incarnation = incarnation_;
    hello.transitions = rollout_.env_steps();
    hello.actor_id = identity_.actor_id;
    hello.generation = identity_.generation;
    hello.observation_size = observation_size_;
    hello.git_revision = GitRevision();
    hello.isa = GemmTarget();
    bus_->Publish(Plane::kExperience, kHelloChannel, hello);
  }
  return false;
}

bool Actor::ReceiveTable() {
  if (auto tables = tables_.Take()) {
    scene_->SetTable(std::make_shared<RoadmapLookup>(tables->positions.dimension,
                                                     std::move(tables->positions.positions), std::move(tables->table),
                                                     experiment_.planner.r_ball(), tables->positions.num_bends));
    has_table_ = true;
    log::Info("cost table {:016x}: longest cost {:.3f} m", control_->table_hash, scene_->d_min_scale());
  }
  if (!running()) return false;
  return welcome_->assignment == assignment_done_ || TakeAssignment();
}

// Of a vehicle that is new here the learner knows how far it is; of one that stays only this process does, since the
// learner's count lags behind what is on the way. False while a state that it shall go on with is not here.
bool Actor::TakeAssignment() {
  std::vector<Bytes> states(welcome_->vehicle.size());
  for (size_t i = 0; i < states.size(); ++i) {
    if (welcome_->state_bytes[i] == 0) continue;
    const Bytes* state = states_.Find(welcome_->vehicle[i], welcome_->steps_done[i]);
    if (state == nullptr) return false;
    states[i] = *state;
  }
  SendExperience();
  rollout_.Assign(welcome_->vehicle, welcome_->next_episode, welcome_->steps_done, states);
  assignment_done_ = welcome_->assignment;
  states_.Clear();
  SendStatus(Clock::now(), Duration::zero());  // others may wait for vehicles that are free now
  return true;
}

std::vector<SavedVehicle> Actor::SaveVehicles() const {
  std::vector<SavedVehicle> saved;
  for (int i = 0; i < rollout_.num_vehicles(); ++i) {
    saved.push_back({rollout_.vehicle(i), rollout_.transitions(i), rollout_.SaveVehicle(i)});
  }
  return saved;
}

bool Actor::UsePolicy(int64_t version) {
  if (version == policy_in_use_ && policy_incarnation_ == incarnation_) return true;
  const std::vector<float>* parameters = policies_.Find(version);
  wanted_policy_version_ = parameters == nullptr ? version : -1;
  if (parameters == nullptr) return false;
  policy_.SetParameters(*parameters);
  policy_in_use_ = version;
  policy_incarnation_ = incarnation_;
  return true;
}

RolloutContext Actor::Context(bool warm_up) { return {&policy_, warm_up, policy_incarnation_, policy_in_use_}; }

// The oldest open round in which a vehicle here has steps left. Whoever is done with one goes on with the next without
// waiting for the other actors.
bool Actor::RollRounds() {
  for (const Control::Round& round : control_->rounds) {
    for (int i = 0; i < rollout_.num_vehicles(); ++i) {
      if (rollout_.transitions(i) < round.Target(rollout_.vehicle(i))) return RollRound(round);
    }
  }
  return false;
}

bool Actor::RollRound(const Control::Round& round) {
  if (!UsePolicy(round.policy_version)) return false;
  const RolloutContext context = Context(round.warm_up);
  std::vector<int> active;
  bool complete = false, stepped = false;
  do {
    active.clear();
    complete = true;
    for (int i = 0; i < rollout_.num_vehicles(); ++i) {
      if (rollout_.transitions(i) >= round.Target(rollout_.vehicle(i))) continue;
      complete = false;
      if (rollout_.Ready(i)) active.push_back(i);
    }
    if (!active.empty()) rollout_.Step(active, context);
    stepped = stepped || !active.empty();
  } while (!active.empty());
  if (!complete) return stepped;  // somebody's table is on its way
  round_done_ = round.round;
  SendExperience(round.save);
  return true;
}

// What is open leaves when it is long or old enough, or when the credit ends, so that the learner never waits for
// something that lies here.
bool Actor::RollCredit() {
  const TimePoint start = Clock::now();
  bool rolled = false;
  while (Clock::now() - start < kRollTime && RollStep()) rolled = true;
  return rolled;
}

// One step of as many vehicles as the credit pays for.
bool Actor::RollStep() {
  const TimePoint now = Clock::now();
  const bool end_of_credit = !me_ || me_->credit <= rollout_.env_steps();
  const int64_t open_steps = rollout_.env_steps() - flushed_steps_;
  if (open_steps == 0) open_since_ = now;
  const bool long_enough = open_steps >= int64_t{kAsyncSegmentSteps} * rollout_.num_vehicles();
  if (end_of_credit || open_steps == 0 || now - open_since_ > (long_enough ? kLeastFlushInterval : kFlushInterval)) {
    SendExperience();
    if (end_of_credit || rollout_.num_vehicles() == 0) return false;
    open_since_ = now;
    const bool newest = UsePolicy(std::max(control_->policy_version, policies_.newest()));
    if (!newest && (policy_in_use_ < 0 || policy_incarnation_ != incarnation_)) return false;
  }
  const auto n = static_cast<size_t>(rollout_.num_vehicles());
  const int64_t credit = me_->credit - rollout_.env_steps();
  std::vector<int> indices;
  for (size_t i = 0; i < n && static_cast<int64_t>(indices.size()) < credit; ++i) {
    const int index = static_cast<int>(next_vehicle_);
    if (rollout_.Ready(index)) indices.push_back(index);
    next_vehicle_ = (next_vehicle_ + 1) % n;
  }
  if (indices.empty()) return false;
  std::sort(indices.begin(), indices.end());
  rollout_.Step(indices, Context(control_->warm_up));
  return true;
}

// For a while, or until all wait for tables; returns true when it did something.
bool Actor::Evaluate() {
  if (evaluation_ && evaluation_->id != control_->evaluation_id) evaluation_.reset();  // it was shared out anew
  if (!evaluation_ && !BeginEvaluation()) return false;
  if (!evaluation_->batch.done() && !UsePolicy(evaluation_->version)) return false;
  PolicyController controller(policy_, EvaluationOptions{}.max_batch);
  const TimePoint start = Clock::now();
  bool stepped = true;
  while (stepped && !evaluation_->batch.done() && Clock::now() - start < kEvaluateTime) {
    stepped = evaluation_->batch.Step(controller);
  }
  if (evaluation_->batch.done()) FinishEvaluation();
  return stepped;
}

// The disturbances are keyed by the policy's version: ids of evaluations depend on timing, versions do not.
bool Actor::BeginEvaluation() {
  if (control_->evaluation_id <= evaluation_done_ || leaving_) return false;
  if (!me_ || me_evaluation_ != control_->evaluation_id) return false;
  if (!control_->lockstep) SendExperience();  // segments never span a policy version
  std::vector<int> starts(static_cast<size_t>(me_->evaluation_count));
  std::iota(starts.begin(), starts.end(), me_->evaluation_first);
  EvaluationOptions options;
  options.policy_version = control_->evaluation_version;
  options.evaluation = EvaluationOptions::KeyOf(options.policy_version);
  evaluation_.emplace(
      RunningEvaluation{control_->evaluation_id, control_->evaluation_version,
                        EvaluationBatch(course_, control_->evaluation_set, std::move(starts), options)});
  return true;
}

void Actor::FinishEvaluation() {
  evaluation_results_ = evaluation_->batch.results();
  for (EpisodeResult& result : evaluation_results_) {
    result.episode = static_cast<int32_t>(evaluation_->id);
    eval_steps_ += result.steps;
  }
  evaluation_done_ = evaluation_->id;
  evaluation_.reset();
  SendExperience();
}

// --- what goes out ---------------------------------------------------------------------------------------------------

void Actor::SendExperience(bool with_states) {
  std::vector<Segment> segments = rollout_.TakeSegments();
  flushed_steps_ = rollout_.env_steps();
  const std::vector<SavedVehicle> states = with_states ? SaveVehicles() : std::vector<SavedVehicle>();
  std::vector<EpisodeResult> episodes = rollout_.TakeEpisodes();
  episodes.insert(episodes.end(), evaluation_results_.begin(), evaluation_results_.end());
  evaluation_results_.clear();
  for (const Segment& segment : segments) audit_.Add(segment, observation_size_, action_size_);
  audit_.Flush();
  const int max_bytes = bus_->max_message_bytes() - static_cast<int>(kTrailerBytes) - 64;
  for (Experience& message :
       PackExperience(std::move(segments), episodes, states, observation_size_, action_size_, max_bytes)) {
    message.session = bus_->config().session;
    message.actor_id = identity_.actor_id;
    message.sequence = stream_.next_sequence();
    stream_.Push(Encode(message), Clock::now());
  }
}

void Actor::SendStatus(TimePoint now, Duration interval) {
  if (!joined_ || now - last_status_ < interval) return;
  last_status_ = now;
  ActorStatus status;
  status.session = bus_->config().session;
  status.actor_id = identity_.actor_id;
  status.assignment = assignment_done_;
  status.round = round_done_;
  status.policy_version = policies_.newest();
  status.wanted_policy_version = wanted_policy_version_;
  status.last_sequence = stream_.last_sequence();
  status.sent = stream_.sent();
  status.resent = stream_.resent();
  status.wait_us = std::chrono::duration_cast<std::chrono::microseconds>(waited_).count();
  status.round_trip_us = stream_.round_trip_us();
  status.leaving = leaving_;
  bus_->Publish(Plane::kExperience, kStatusChannel, status);
}

void Actor::SendTelemetry(TimePoint now) {
  const double seconds = std::chrono::duration<double>(now - last_telemetry_).count();
  if (seconds < 1.0) return;
  ActorTelemetry telemetry;
  telemetry.actor_id = identity_.actor_id;
  telemetry.num_vehicles = rollout_.num_vehicles();
  telemetry.env_steps = rollout_.env_steps();
  telemetry.eval_steps = eval_steps_;
  telemetry.episodes = rollout_.num_episodes();
  telemetry.policy_version = policy_in_use_;
  telemetry.sent_messages = stream_.sent();
  telemetry.resent_messages = stream_.resent();
  telemetry.env_steps_per_s = static_cast<double>(rollout_.env_steps() - telemetry_env_steps_) / seconds;
  telemetry.busy = std::min(1.0, busy_s_ / seconds);
  if (const Environment* first = rollout_.first()) {
    const Pose pose = first->pose();
    telemetry.pose = {static_cast<float>(pose.x), static_cast<float>(pose.y), static_cast<float>(pose.z),
                      static_cast<float>(pose.yaw)};
    telemetry.d_min = first->d_min();
  }
  bus_->Publish(Plane::kTelemetry, ActorChannel(identity_.actor_id), telemetry);
  last_telemetry_ = now;
  telemetry_env_steps_ = rollout_.env_steps();
  busy_s_ = 0;
}

}  // namespace cairn::actors
