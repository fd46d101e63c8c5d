// Rates of the actors' side: physics, contact, observation, the full environment step and the batched policy loop.
//
// `full_step/*` answers how much of the time goes into anything but physics: it plays the same episodes, action by
// action, first with physics and contact tests alone and then through Environment, in turns within one run, so that
// the ratio of the two holds on a busy machine too.

#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "actors/contact_test.h"
#include "actors/controllers/policy_controller.h"
#include "actors/environment.h"
#include "actors/observation.h"
#include "common/core/clock.h"
#include "tests/benchmarks/episode_tapes.h"

namespace cairn::actors {
namespace {

constexpr int kCarActions = 2;  // speed and yaw rate

Experiment MakeExperiment(VehicleConfig::Kind kind) {
  Experiment experiment;
  experiment.vehicle.kind = kind;
  return experiment;
}

// The same episode through the environment, with an observation for every action; returns control steps.
int64_t PlayFull(Environment& environment, const Tape& tape, std::vector<float>& observation) {
  environment.ResetTraining(0, tape.episode);
  environment.Observe(observation.data());
  const auto size = static_cast<size_t>(environment.scene().experiment().vehicle.action_size());
  for (size_t i = 0; i < tape.actions.size(); i += size) {
    const StepResult result = environment.Step(tape.actions.data() + i);
    environment.Observe(observation.data());
    benchmark::DoNotOptimize(observation.data());
    if (result.end != SegmentEnd::kNone) break;
  }
  return environment.episode().steps;
}

void FullStep(benchmark::State& state, VehicleConfig::Kind kind) {
  const auto scene = MakeGridScene(MakeExperiment(kind), 0.03);
  const std::vector<Tape> tapes = RecordTapes(scene, 20);
  PhysicsAndContact physics(*scene);
  Environment environment(scene);
  std::vector<float> observation(static_cast<size_t>(ObservationSize(scene->experiment())));
  double physics_s = 0, full_s = 0;
  int64_t physics_steps = 0, control_steps = 0;
  size_t next = 0;
  for (auto _ : state) {
    const Tape& tape = tapes[next++ % tapes.size()];
    const TimePoint start = Clock::now();
    physics_steps += physics.Play(tape);
    physics_s += SecondsSince(start);
    const TimePoint middle = Clock::now();
    control_steps += PlayFull(environment, tape, observation);
    const double seconds = SecondsSince(middle);
    full_s += seconds;
    state.SetIterationTime(seconds);
  }
  state.counters["physics_contact_steps_per_s"] = static_cast<double>(physics_steps) / physics_s;
  state.counters["physics_steps_per_s_in_full"] = static_cast<double>(physics_steps) / full_s;
  state.counters["env_steps_per_s"] = static_cast<double>(control_steps) / full_s;
  state.counters["ratio"] = physics_s / full_s;
}
BENCHMARK_CAPTURE(FullStep, wheeled_car, VehicleConfig::Kind::kWheeledCar)
    ->UseManualTime()
    ->Name("full_step/wheeled_car");
BENCHMARK_CAPTURE(FullStep, plane_car, VehicleConfig::Kind::kPlaneCar)->UseManualTime()->Name("full_step/plane_car");

void Physics(benchmark::State& state, VehicleConfig::Kind kind) {
  const Experiment experiment = MakeExperiment(kind);
  const auto vehicle = MakeVehicle(experiment.vehicle, experiment.environment);
  RandomStream random(1, RandomPurpose::kTest);
  vehicle->Reset({0, 0, 0}, random);
  int step = 0;
  for (auto _ : state) {
    if (step++ % 24 == 0) vehicle->Command({random.Uniform(0.2, 0.8), random.Uniform(-1, 1)});
    vehicle->Step();
    benchmark::DoNotOptimize(vehicle->motion());
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK_CAPTURE(Physics, wheeled_car, VehicleConfig::Kind::kWheeledCar)->Name("physics/wheeled_car");
BENCHMARK_CAPTURE(Physics, plane_car, VehicleConfig::Kind::kPlaneCar)->Name("physics/plane_car");

std::vector<Motion> FreeStates(const Scene& scene, int count) {
  std::vector<Motion> states;
  for (int i = 0; i < count; ++i) {
    const Pose pose = scene.TrainingStart(0, i);
    states.push_back({pose.x, pose.y, 0, pose.yaw, 0.4, 0, 0, 0.2});
  }
  return states;
}

void Observation(benchmark::State& state, bool look_ahead, bool rays) {
  Experiment experiment = MakeExperiment(VehicleConfig::Kind::kPlaneCar);
  experiment.observation.look_ahead = look_ahead;
  experiment.observation.rays = rays;
  const auto scene = MakeGridScene(experiment, 0.03);
  const ObservationBuilder builder(*scene);
  const std::vector<Motion> states = FreeStates(*scene, 256);
  std::vector<float> out(static_cast<size_t>(builder.size()));
  size_t next = 0;
  for (auto _ : state) {
    builder.Build(states[next++ % states.size()], 1.0f, out.data());
    benchmark::DoNotOptimize(out.data());
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK_CAPTURE(Observation, full, true, true)->Name("observation/full");
BENCHMARK_CAPTURE(Observation, rays, false, true)->Name("observation/16_rays");
BENCHMARK_CAPTURE(Observation, look_ahead, true, false)->Name("observation/look_ahead");

void ContactTests(benchmark::State& state) {
  const auto scene = MakeGridScene(MakeExperiment(VehicleConfig::Kind::kPlaneCar), 0.03);
  const ContactTest contact(*scene);
  const std::vector<Motion> states = FreeStates(*scene, 256);
  size_t next = 0;
  for (auto _ : state) {
    const Motion& s = states[next++ % states.size()];
    benchmark::DoNotOptimize(contact.Touches(s, contact.CenterDistance(s)));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(ContactTests)->Name("contact_test");

// What an actor does all day: observe, infer, step; one iteration is one control step of all vehicles.
void PolicyLoop(benchmark::State& state, VehicleConfig::Kind kind) {
  const Experiment experiment = MakeExperiment(kind);
  const auto scene = MakeGridScene(experiment, 0.03);
  PolicyShape shape;
  shape.observation_size = ObservationSize(experiment);
  shape.action_size = kCarActions;
  shape.net_arch = {64, 64};
  const int vehicles = static_cast<int>(state.range(0));
  Policy policy(shape, vehicles);
  std::vector<float> parameters(shape.num_parameters());
  RandomStream random(1, RandomPurpose::kTest);
  for (float& p : parameters) p = static_cast<float>(0.1 * random.Normal());
  policy.SetParameters(parameters);
  PolicyController controller(policy, vehicles);
  std::vector<std::unique_ptr<Environment>> environments;
  std::vector<const Environment*> pointers;
  for (int vehicle = 0; vehicle < vehicles; ++vehicle) {
    environments.push_back(std::make_unique<Environment>(scene));
    environments.back()->ResetTraining(vehicle, 0);
    pointers.push_back(environments.back().get());
  }
  std::vector<float> actions(static_cast<size_t>(vehicles) * kCarActions);
  for (auto _ : state) {
    controller.Act(pointers, actions.data());
    for (int vehicle = 0; vehicle < vehicles; ++vehicle) {
      Environment& environment = *environments[static_cast<size_t>(vehicle)];
      if (environment.Step(&actions[static_cast<size_t>(vehicle) * kCarActions]).end == SegmentEnd::kNone) continue;
      environment.ResetTraining(vehicle, environment.episode().episode + 1);
    }
  }
  state.SetItemsProcessed(state.iterations() * vehicles);
}
BENCHMARK_CAPTURE(PolicyLoop, wheeled_car, VehicleConfig::Kind::kWheeledCar)->Arg(16)->Name("policy_loop/wheeled_car");
BENCHMARK_CAPTURE(PolicyLoop, plane_car, VehicleConfig::Kind::kPlaneCar)->Arg(16)->Name("policy_loop/plane_car");

}  // namespace
}  // namespace cairn::actors

BENCHMARK_MAIN();
