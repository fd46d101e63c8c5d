#include "actors/environment.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "actors/blob.h"
#include "actors/command.h"
#include "actors/command_delay.h"
#include "actors/contact_test.h"
#include "actors/disturbance.h"
#include "actors/episode_meter.h"
#include "actors/episode_streams.h"
#include "actors/localization.h"
#include "actors/observation.h"
#include "actors/persons.h"
#include "actors/rewards/reward.h"
#include "actors/safety/safety_filter.h"
#include "common/core/check.h"
#include "common/core/log.h"

namespace cairn::actors {
namespace {

bool IsFinite(const Motion& m) {
  return std::isfinite(m.x) && std::isfinite(m.y) && std::isfinite(m.z) && std::isfinite(m.yaw) &&
         std::isfinite(m.vx) && std::isfinite(m.vy) && std::isfinite(m.vz) && std::isfinite(m.yaw_rate);
}

// Field by field: the struct has padding, and equal episodes shall give equal blobs.
void WriteResult(const EpisodeResult& r, BlobWriter& blob) {
  blob.Put(r.set), blob.Put(r.vehicle), blob.Put(r.episode), blob.Put(r.steps), blob.Put(r.outcome);
  blob.Put(r.policy_version), blob.Put(r.episode_return), blob.Put(r.duration), blob.Put(r.path_length);
  blob.Put(r.shortest_length), blob.Put(r.min_clearance), blob.Put(r.mean_jerk), blob.Put(r.filtered_steps);
}

void ReadResult(EpisodeResult& r, BlobReader& blob) {
  blob.Get(r.set), blob.Get(r.vehicle), blob.Get(r.episode), blob.Get(r.steps), blob.Get(r.outcome);
  blob.Get(r.policy_version), blob.Get(r.episode_return), blob.Get(r.duration), blob.Get(r.path_length);
  blob.Get(r.shortest_length), blob.Get(r.min_clearance), blob.Get(r.mean_jerk), blob.Get(r.filtered_steps);
}

}  // namespace

struct Environment::State {
  explicit State(const Scene& s)
      : scene(s),
        vehicle(MakeVehicle(s.experiment().vehicle, s.experiment().environment)),
        builder(s),
        reward(MakeReward(s.experiment())),
        persons(s),
        contact(s, s.experiment().world.persons > 0 ? &persons : nullptr),
        meter(s, contact),
        disturbance(s.experiment().environment, s.experiment().vehicle),
        delay(s.experiment(), s.control_physics_steps()),
        localization(s.experiment()),
        last_actions(static_cast<size_t>(s.experiment().observation.last_actions) *
                     s.experiment().vehicle.action_size()) {
    if (s.experiment().safety.filter != SafetyConfig::Filter::kOff) filter.emplace(s);
  }

  void StartStreams(const EpisodeResult& episode);
  void Place(const EpisodeResult& episode, const Pose& start, int step_limit);
  bool Drive(int step, StepEvent& event);
  VehicleCommand Filter(const VehicleCommand& command);
  bool StepPhysics();
  StepEvent FindEvent();
  Vector3d position() const { return {n.motion.x, n.motion.y, n.motion.z}; }
  float Distance(const Vector3d& p) const { return reward->Distance(scene, p); }
  float ShortestLength(float distance) const;

  // Looks of the observation have even numbers, those of the filter odd ones.
  RangeFinder Look(bool of_filter) const {
    return {scene, &persons, range_noise, 2 * static_cast<uint64_t>(n.physics_steps) + (of_filter ? 1 : 0)};
  }

  const Scene& scene;
  std::unique_ptr<Vehicle> vehicle;
  ObservationBuilder builder;
  std::unique_ptr<Reward> reward;
  Persons persons;
  ContactTest contact;
  EpisodeMeter meter;
  HeldDisturbance disturbance;
  CommandDelay delay;
  Localization localization;
  std::optional<SafetyFilter> filter;
  std::vector<float> last_actions;  // newest first
  // Positions are set where they are used, so that observing twice gives the same.
  RandomStream observation_noise{0, RandomPurpose::kObservationNoise};
  RandomStream range_noise{0, RandomPurpose::kRanges};
  // All eight bytes wide: no padding in the blob.
  struct Numbers {
    Motion motion;              // the last finite one
    double d_min = 0;           // a float's value
    double believed_d_min = 0;  // a float's value: D_min of the places where the vehicle believed to be
    double episode_return = 0;
    double footprint_scale = 1;
    int64_t filters = 0;  // whether the filter works in this episode
    int64_t physics_steps = 0;
    int64_t step_limit = 0;
  } n;
};

void Environment::State::StartStreams(const EpisodeResult& episode) {
  const uint64_t seed = scene.experiment().seed;
  disturbance.Reset(EpisodeStream(seed, episode, NoiseUse::kDisturbance),
                    EpisodeStream(seed, episode, NoiseUse::kSlip));
  observation_noise = EpisodeStream(seed, episode, NoiseUse::kObservation);
  range_noise = EpisodeStream(seed, episode, NoiseUse::kRanges);
  localization.Reset(EpisodeStream(seed, episode, NoiseUse::kLocalization));
}

void Environment::State::Place(const EpisodeResult& episode, const Pose& start, int step_limit) {
  const Experiment& experiment = scene.experiment();
  const bool evaluates = episode.set != StartSet::kTraining;
  RandomStream parameters = EpisodeStream(experiment.seed, episode, NoiseUse::kParameters);
  vehicle->Reset(start, parameters);
  n = Numbers{};
  n.motion = {start.x, start.y, start.z, start.yaw, 0, 0, 0, 0};
  n.step_limit = step_limit;
  n.d_min = n.believed_d_min = Distance(position());
  n.filters = experiment.safety.filter == SafetyConfig::Filter::kAlways ||
              (evaluates && experiment.safety.filter == SafetyConfig::Filter::kEvaluation);
  delay.Reset(parameters);
  std::fill(last_actions.begin(), last_actions.end(), 0.0f);
  if (filter) filter->Reset();
  const double spread = experiment.environment.footprint_spread;
  n.footprint_scale =
      experiment.environment.footprint_scale * (spread > 0 ? parameters.Uniform(1 - spread, 1 + spread) : 1);
  contact.SetScale(n.footprint_scale);
  persons.Reset(position(), evaluates || experiment.world.persons_when == WorldConfig::BlockedWhen::kAlways,
                EpisodeStream(experiment.seed, episode, NoiseUse::kPersons));
  meter.Reset(n.motion);
}

VehicleCommand Environment::State::Filter(const VehicleCommand& command) {
  RangeFinder ranges = Look(true);
  return filter->Apply({command, *vehicle, n.motion, contact.CenterDistance(n.motion), n.physics_steps}, ranges);
}

// Control step `step`, whose command has been pushed; false when the state is no longer finite. The first event ends
// it.
bool Environment::State::Drive(int step, StepEvent& event) {
  const int steps = scene.control_physics_steps();
  VehicleCommand command{};
  int in_force = -2;
  bool filtered = false;
  for (int i = 0; i < steps && event == StepEvent::kNone; ++i) {
    bool changes = disturbance.Advance(n.physics_steps);
    const bool arrives = delay.InForce(step, i) != in_force;
    const bool looks = n.filters != 0 && n.physics_steps % filter->period() == 0;
    if (i == 0 || arrives || looks) {
      in_force = delay.InForce(step, i);
      command = delay.command(in_force);
      if (n.filters != 0) {
        command = Filter(command);
        filtered = filtered || filter->changed();
      }
      changes = true;
    }
    if (changes) vehicle->Command(disturbance.Apply(command));
    if (!StepPhysics()) return false;
    event = FindEvent();
  }
  if (filtered) meter.AddFilteredStep();
  if (event == StepEvent::kNone) meter.AddControlStep(n.motion);
  return true;
}

bool Environment::State::StepPhysics() {
  try {
    vehicle->Step();
  } catch (const Error& error) {  // ODE's own checks
    log::Warning("episode ended as diverged: {}", error.what());
    return false;
  }
  ++n.physics_steps;
  const Motion next = vehicle->motion();
  if (!IsFinite(next)) return false;
  n.motion = next;
  if (!persons.empty()) persons.Walk(1 / scene.experiment().environment.physics_rate_hz, position());
  return true;
}

StepEvent Environment::State::FindEvent() {
  const double center_distance = contact.CenterDistance(n.motion);
  meter.AddPhysicsStep(n.motion, center_distance);
  if (contact.Touches(n.motion, center_distance)) {
    meter.SetContact();
    return StepEvent::kObstacle;
  }
  if (vehicle->fallen()) return StepEvent::kObstacle;
  const World& world = scene.world();
  if (!world.Contains(scene.goal(), position())) return StepEvent::kNone;
  meter.MeasureClearance(n.motion, center_distance);
  return StepEvent::kGoal;
}

// The roadmap's length from here; near the edge of free space, where D is infinite, through the nearest way in.
float Environment::State::ShortestLength(float distance) const {
  if (std::isfinite(distance)) return distance;
  const Vector3d p = position();
  const RoadmapLookup& lookup = scene.lookup();
  const int entry = lookup.EntryVertex(p, scene.known_field(), 0);
  if (entry < 0) return distance;
  return static_cast<float>((lookup.position(entry) - p).norm() + lookup.table().cost[entry]);
}

Environment::Environment(const Scene& scene)
    : scene_(std::make_unique<Scene>(scene)), state_(std::make_unique<State>(*scene_)) {}

Environment::~Environment() = default;

void Environment::Enter(const Scene& scene) { *scene_ = scene; }

void Environment::ResetTraining(int vehicle, int episode, int start_episode) {
  EpisodeResult next;
  next.vehicle = vehicle;
  next.episode = episode;
  Start(next, scene_->TrainingStart(vehicle, start_episode), EpisodeSteps(scene_->experiment(), scene_->d_min_scale()));
}

void Environment::ResetEvaluation(StartSet set, int index, int evaluation) {
  ResetEvaluation(set, index, evaluation, scene_->EvaluationStart(set, index));
}

void Environment::ResetEvaluation(StartSet set, int index, int evaluation, const Pose& start) {
  EpisodeResult next;
  next.set = set;
  next.vehicle = index;
  next.episode = evaluation;
  Start(next, start, EvaluationSteps(scene_->experiment(), scene_->d_min_scale()));
}

void Environment::Start(const EpisodeResult& next, const Pose& start, int step_limit) {
  CAIRN_CHECK(scene_->has_table(), "an episode needs a cost table");
  // Nothing of a diverged world is worth keeping.
  if (episode_.outcome == Outcome::kDiverged) state_ = std::make_unique<State>(*scene_);
  episode_ = next;
  state_->StartStreams(episode_);
  state_->Place(episode_, start, step_limit);
  episode_.shortest_length = state_->ShortestLength(scene_->lookup().CostToGo(state_->position()));
  state_->meter.Fill(episode_);
}

void Environment::Observe(float* observation) const {
  RangeFinder ranges = state_->Look(false);
  state_->builder.Build(state_->n.motion, believed_pose(), static_cast<float>(state_->n.believed_d_min), ranges,
                        state_->last_actions, observation);
  const double noise = scene_->experiment().environment.observation_noise;
  if (noise == 0) return;
  const int size = state_->builder.size();
  RandomStream random = state_->observation_noise;
  random.SetPosition(uint64_t{2} * static_cast<uint64_t>(size) * static_cast<uint64_t>(episode_.steps));
  for (int i = 0; i < size; ++i) observation[i] += static_cast<float>(noise * random.Normal());
}

StepResult Environment::Step(const float* action) {
  CAIRN_CHECK(episode_.outcome == Outcome::kRunning, "the episode is over ({}): reset first",
              OutcomeName(episode_.outcome));
  StepEvent event = StepEvent::kNone;
  const VehicleConfig& vehicle = scene_->experiment().vehicle;
  const bool finite = std::all_of(action, action + vehicle.action_size(), [](float a) { return std::isfinite(a); }) &&
                      Drive(action, event);
  ++episode_.steps;
  state_->localization.Advance(episode_.steps);
  return finite ? Finish(event) : Diverge();
}

bool Environment::Drive(const float* action, StepEvent& event) {
  state_->delay.Push(episode_.steps, ToCommand(scene_->experiment().vehicle, action));
  if (auto& last = state_->last_actions; !last.empty()) {
    const int size = scene_->experiment().vehicle.action_size();
    std::copy_backward(last.begin(), last.end() - size, last.end());
    std::copy_n(action, size, last.begin());
  }
  return state_->Drive(episode_.steps, event);
}

StepResult Environment::Finish(StepEvent event) {
  State& s = *state_;
  const float distance = s.Distance(s.position());
  StepResult result;
  result.reward = s.reward->Evaluate(event, d_min(), distance);
  s.n.d_min = std::min<double>(s.n.d_min, distance);
  s.n.believed_d_min = std::min<double>(s.n.believed_d_min, BelievedDistance(distance));
  s.n.episode_return += result.reward;
  if (event != StepEvent::kNone) {
    episode_.outcome = event == StepEvent::kGoal ? Outcome::kGoal : Outcome::kCollision;
    result.end = SegmentEnd::kTerminated;
  } else if (episode_.steps >= s.n.step_limit) {
    episode_.outcome = Outcome::kTimeout;
    result.end = SegmentEnd::kTruncated;
  }
  episode_.episode_return = static_cast<float>(s.n.episode_return);
  s.meter.Fill(episode_);
  return result;
}

// `distance` is D where the vehicle is.
float Environment::BelievedDistance(float distance) const {
  if (!state_->localization.active()) return distance;
  const Pose pose = believed_pose();
  return state_->Distance({pose.x, pose.y, pose.z});
}

StepResult Environment::Diverge() {
  episode_.outcome = Outcome::kDiverged;
  state_->meter.Fill(episode_);
  return {0, SegmentEnd::kTruncated};
}

Pose Environment::pose() const { return state_->n.motion.pose(); }

const Motion& Environment::motion() const { return state_->n.motion; }

float Environment::d_min() const { return static_cast<float>(state_->n.d_min); }

Pose Environment::believed_pose() const { return state_->localization.Believe(pose(), episode_.steps); }

RangeFinder Environment::Look() const { return state_->Look(false); }

const std::vector<Cylinder>& Environment::persons() const { return state_->persons.bodies(); }

void Environment::SetTable(std::shared_ptr<const RoadmapLookup> lookup) {
  scene_->SetTable(std::move(lookup));
  const float distance = state_->Distance(state_->position());
  state_->n.d_min = distance;
  state_->n.believed_d_min = BelievedDistance(distance);
}

Findings Environment::FindSurprises() const {
  Findings findings;
  const SurpriseFinder finder(*scene_);
  if (scene_->experiment().planner.repair == PlannerConfig::Repair::kRays) {
    RangeFinder ranges = Look();
    finder.LookAround(motion(), ranges, &findings);
  }
  if (episode_.outcome == Outcome::kCollision) finder.Touch(motion(), &findings);
  return findings;
}

std::string Environment::Save() const {
  BlobWriter blob;
  WriteResult(episode_, blob);
  blob.Put(state_->n);
  state_->meter.Write(blob);
  state_->disturbance.Write(blob);
  state_->delay.Write(blob);
  for (const float action : state_->last_actions) blob.Put(action);
  state_->localization.Write(blob);
  state_->persons.Write(blob);
  if (state_->filter) state_->filter->Write(blob);
  blob.PutBytes(state_->vehicle->Save());
  return blob.Take();
}

void Environment::Load(const std::string& bytes) {
  BlobReader blob(bytes);
  ReadResult(episode_, blob);
  state_->StartStreams(episode_);
  blob.Get(state_->n);
  state_->meter.Read(blob);
  state_->disturbance.Read(blob);
  state_->delay.Read(blob);
  for (float& action : state_->last_actions) blob.Get(action);
  state_->localization.Read(blob);
  state_->persons.Read(blob);
  if (state_->filter) state_->filter->Read(blob);
  state_->contact.SetScale(state_->n.footprint_scale);
  state_->vehicle->Load(blob.GetBytes());
  blob.Finish();
}

}  // namespace cairn::actors
