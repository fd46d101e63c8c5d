#include "actors/actor.h"

#include <algorithm>
#include <numeric>

#include "actors/controllers/policy_controller.h"
#include "actors/evaluation.h"
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
constexpr auto kIdleStatus = milliseconds(1000);
constexpr auto kFlushInterval = milliseconds(50);  // ASYNC: no transition is older than this when it leaves
constexpr int kAsyncSegmentSteps = 10;

}  // namespace

Actor::Actor(Bus* bus, const Experiment& experiment, const ActorIdentity& identity)
    : bus_(bus),
      experiment_(experiment),
      identity_(identity),
      observation_size_(ObservationSize(experiment)),
      scene_(std::make_shared<Scene>(experiment)),
      tables_(bus, identity.experiment_hash),
      policies_(static_cast<int>(MakePolicyShape(experiment).num_parameters())),
      policy_(MakePolicyShape(experiment), std::max(64, experiment.num_vehicles)),
      rollout_(scene_),
      stream_([this](const Bytes& message) {
        bus_->PublishBytes(Plane::kExperience, ExperienceChannel(identity_.actor_id), message);
      }),
      audit_(fmt::format("actor-{:04}-{:02}", identity.actor_id, identity.generation)) {}

void Actor::Subscribe() {
  bus_->Subscribe<Welcome>(Plane::kControl, kWelcomeChannel,
                           [this](const Welcome& welcome, const FrameInfo&) { OnWelcome(welcome); });
  bus_->Subscribe<Control>(Plane::kControl, kControlChannel,
                           [this](const Control& control, const FrameInfo&) { OnControl(control); });
  bus_->Subscribe<PolicyChunk>(Plane::kControl, kPolicyChannel,
                               [this](const PolicyChunk& chunk, const FrameInfo&) { policies_.Add(chunk); });
  bus_->Subscribe<AssignedState>(Plane::kControl, kStateChannel,
                                 [this](const AssignedState& state, const FrameInfo&) { OnState(state); });
  bus_->CheckPlanes();
}

void Actor::Run() {
  Subscribe();
  Duration wait = Duration::zero();
  while (!finished()) {
    bus_->Poll(wait);
    if (!refusal_.empty()) ThrowUsageError("the learner refused actor {}: {}", identity_.actor_id, refusal_);
    const TimePoint start = Clock::now();
    tables_.Poll(start);
    stream_.Poll(start);
    const bool worked =
        Join(start) && ReceiveTable() && (Evaluate() || (control_->lockstep ? RollRounds() : RollCredit()));
    const TimePoint now = Clock::now();
    if (worked) busy_s_ += std::chrono::duration<double>(now - start).count();
    SendStatus(now, worked ? Duration(kIdleStatus) : Duration(kWaitingStatus));
    SendTelemetry(now);
    wait = worked ? Duration::zero() : Duration(milliseconds(5));
  }
}

// --- what comes in ---------------------------------------------------------------------------------------------------

void Actor::OnWelcome(const Welcome& welcome) {
  if (welcome.session != bus_->config().session) return;
  if (welcome.status == Welcome::Status::kRefused) refusal_ = welcome.reason;
  if (welcome.status != Welcome::Status::kAccepted) return;
  if (welcome_ && welcome.assignment <= welcome_->assignment) return;
  welcome_ = welcome;
  states_.Clear();
  policies_.SetIncarnation(welcome.incarnation);
}

void Actor::OnState(const AssignedState& state) {
  if (!welcome_ || state.session != welcome_->session || state.assignment != welcome_->assignment) return;
  if (state.assignment > assignment_done_) states_.Add(state.piece);
}

void Actor::OnControl(const Control& control) {
  // Datagrams of one sender may overtake each other; only newer state counts.
  if (control_ && control.incarnation == control_->incarnation && control.number <= control_->number) return;
  control_ = control;
  policies_.SetIncarnation(control.incarnation);
  if (control.evaluation_id != 0) policies_.Pin(control.evaluation_version);
  tables_.Want(control.roadmap_hash, control.table_hash);
  const Control::Actor* me = Myself();
  if (me != nullptr) stream_.Acknowledge(me->received, me->window, me->echo_utime, Clock::now());
}

const Control::Actor* Actor::Myself() const {
  if (!control_) return nullptr;
  const auto it = std::find_if(control_->actors.begin(), control_->actors.end(),
                               [this](const Control::Actor& a) { return a.session == bus_->config().session; });
  return it == control_->actors.end() ? nullptr : &*it;
}

// --- what it does ----------------------------------------------------------------------------------------------------

bool Actor::Join(TimePoint now) {
  if (welcome_) return control_.has_value();
  if (now >= next_hello_) {
    next_hello_ = now + kHelloInterval;
    Hello hello;
    hello.session = bus_->config().session;
    hello.experiment_hash = identity_.experiment_hash;
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
                                                     experiment_.planner.r_ball()));
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
  if (version == policy_in_use_) return true;
  const std::vector<float>* parameters = policies_.Find(version);
  wanted_policy_version_ = parameters == nullptr ? version : -1;
  if (parameters == nullptr) return false;
  policy_.SetParameters(*parameters);
  policy_in_use_ = version;
  return true;
}

RolloutContext Actor::Context(bool warm_up) {
  return {&policy_, warm_up, control_->incarnation, policy_in_use_, control_->table_hash};
}

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
  do {
    active.clear();
    for (int i = 0; i < rollout_.num_vehicles(); ++i) {
      if (rollout_.transitions(i) < round.Target(rollout_.vehicle(i))) active.push_back(i);
    }
    if (!active.empty()) rollout_.Step(active, context);
  } while (!active.empty());
  round_done_ = round.round;
  SendExperience(round.save);
  return true;
}

// One step of as many vehicles as the credit pays for; what is open leaves when it is long or old enough, or when the
// credit ends, so that the learner never waits for something that lies here.
bool Actor::RollCredit() {
  const Control::Actor* me = Myself();
  const TimePoint now = Clock::now();
  const bool end_of_credit = me == nullptr || me->credit <= credit_used_;
  if (end_of_credit || now - last_flush_ > kFlushInterval ||
      rollout_.env_steps() % (int64_t{kAsyncSegmentSteps} * std::max(1, rollout_.num_vehicles())) == 0) {
    SendExperience();
    last_flush_ = now;
    if (control_->policy_version != policy_in_use_ && !UsePolicy(control_->policy_version) && policy_in_use_ < 0) {
      return false;
    }
  }
  if (end_of_credit || rollout_.num_vehicles() == 0) return false;
  const auto n = static_cast<size_t>(rollout_.num_vehicles());
  const auto count = static_cast<size_t>(std::min<int64_t>(static_cast<int64_t>(n), me->credit - credit_used_));
  std::vector<int> indices(count);
  for (int& index : indices) {
    index = static_cast<int>(next_vehicle_);
    next_vehicle_ = (next_vehicle_ + 1) % n;
  }
  std::sort(indices.begin(), indices.end());
  const int64_t before = rollout_.env_steps();
  rollout_.Step(indices, Context(control_->warm_up));
  credit_used_ += rollout_.env_steps() - before;
  return true;
}

bool Actor::Evaluate() {
  if (control_->evaluation_id <= evaluation_done_) return false;
  const Control::Actor* me = Myself();
  if (me == nullptr) return false;
  if (!control_->lockstep) SendExperience();  // segments never span a policy version
  if (me->evaluation_count > 0 && !UsePolicy(control_->evaluation_version)) return false;
  std::vector<int> starts(static_cast<size_t>(me->evaluation_count));
  std::iota(starts.begin(), starts.end(), me->evaluation_first);
  if (!starts.empty()) {
    evaluation_results_ = RunEvaluation(std::move(starts));
  }
  evaluation_done_ = control_->evaluation_id;
  SendExperience();
  return true;
}

// The disturbances are keyed by the policy's version: ids of evaluations depend on timing, versions do not.
std::vector<EpisodeResult> Actor::RunEvaluation(std::vector<int> starts) {
  EvaluationOptions options;
  options.evaluation = EvaluationOptions::KeyOf(control_->evaluation_version);
  options.policy_version = control_->evaluation_version;
  EvaluationBatch batch(scene_, control_->evaluation_set, std::move(starts), options);
  PolicyController controller(policy_, options.max_batch);
  while (!batch.done()) {
    batch.Step(controller);
    SendStatus(Clock::now(), kIdleStatus);
  }
  std::vector<EpisodeResult> results = batch.results();
  for (EpisodeResult& result : results) {
    result.episode = static_cast<int32_t>(control_->evaluation_id);
    eval_steps_ += result.steps;
  }
  return results;
}

// --- what goes out ---------------------------------------------------------------------------------------------------

void Actor::SendExperience(bool with_states) {
  std::vector<Segment> segments = rollout_.TakeSegments();
  const std::vector<SavedVehicle> states = with_states ? SaveVehicles() : std::vector<SavedVehicle>();
  std::vector<EpisodeResult> episodes = rollout_.TakeEpisodes();
  episodes.insert(episodes.end(), evaluation_results_.begin(), evaluation_results_.end());
  evaluation_results_.clear();
  for (const Segment& segment : segments) audit_.Add(segment, observation_size_, kActionSize);
  audit_.Flush();
  const int max_bytes = MaxMessageBytes(bus_->config().ttl) - static_cast<int>(kTrailerBytes) - 64;
  for (Experience& message :
       PackExperience(std::move(segments), episodes, states, observation_size_, kActionSize, max_bytes)) {
    message.session = bus_->config().session;
    message.actor_id = identity_.actor_id;
    message.sequence = stream_.next_sequence();
    stream_.Push(Encode(message), Clock::now());
  }
}

void Actor::SendStatus(TimePoint now, Duration interval) {
  if (!welcome_ || now - last_status_ < interval) return;
  last_status_ = now;
  ActorStatus status;
  status.session = bus_->config().session;
  status.actor_id = identity_.actor_id;
  status.assignment = assignment_done_;
  status.round = round_done_;
  status.policy_version = policies_.newest();
  status.wanted_policy_version = wanted_policy_version_;
  status.last_sequence = stream_.last_sequence();
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
    telemetry.pose = {static_cast<float>(pose.x), static_cast<float>(pose.y), static_cast<float>(pose.yaw)};
    telemetry.d_min = first->d_min();
  }
  bus_->Publish(Plane::kTelemetry, ActorChannel(identity_.actor_id), telemetry);
  last_telemetry_ = now;
  telemetry_env_steps_ = rollout_.env_steps();
  busy_s_ = 0;
}

}  // namespace cairn::actors
