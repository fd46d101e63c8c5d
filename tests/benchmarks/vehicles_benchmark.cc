// Rates of the vehicles, each in the maze of its experiment file and timed by the thread's CPU clock.
//
// `physics_contact/*`: physics, wall contact and goal, step by step. Where libbullet-dev was found, the same episodes
// (starts and commands) run in Bullet in turns with ours: `ratio_to_bullet` holds on a busy machine too. The last
// number of the name is the iterations of Bullet's solver: 10 is its default, 50 PyBullet's; with few of them joints
// give, so `speed_error` and `speed_error_in_bullet` (RMS of velocity less command at the ends of control steps [m/s],
// without disturbance) stand beside. `full_step/*`: the same through Environment with an observation for each action;
// `ratio` is physics and contact alone over that. `two_actors/*`: what two threads with a vehicle each do over what one
// does, against the same of two loops of fused multiply-adds on registers (`ratio`), in turns.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "actors/command.h"
#include "actors/environment.h"
#include "common/config/load.h"
#include "common/core/clock.h"
#include "tests/benchmarks/cpu_time.h"
#include "tests/benchmarks/episode_tapes.h"
#include "tests/benchmarks/fma_peak.h"
#ifdef CAIRN_BENCH_BULLET
#include "tests/benchmarks/bullet_scene.h"
#endif

namespace cairn::actors {
namespace {

constexpr int kTapes = 20;
constexpr double kTurn = 0.1;  // of one or two threads [s]

std::shared_ptr<const Scene> LoadScene(const std::string& name, const std::vector<std::string>& overrides = {}) {
  const std::string path = std::string(CAIRN_SOURCE_DIR) + "/deploy/experiments/" + name + ".textproto";
  const Experiment experiment = LoadExperiment(path, overrides).experiment;
  return MakeGridScene(experiment, experiment.planner.radius);
}

#ifdef CAIRN_BENCH_BULLET
// The tape's commands from its start until the first contact or the goal; returns physics steps.
int64_t PlayInBullet(BulletScene& bullet, const Scene& scene, const Tape& tape, SpeedError& error) {
  int64_t steps = 0;
  const VehicleConfig& vehicle = scene.experiment().vehicle;
  bullet.Reset(scene.TrainingStart(0, tape.episode));
  for (size_t i = 0; i < tape.actions.size(); i += static_cast<size_t>(vehicle.action_size())) {
    const VehicleCommand command = ToCommand(vehicle, &tape.actions[i]);
    bullet.Command(command);
    for (int k = 0; k < scene.control_physics_steps(); ++k) {
      const bool touches = bullet.Step();
      ++steps;
      const Motion m = bullet.motion();
      if (touches || scene.world().Contains(scene.world().goal, Vector3d(m.x, m.y, m.z))) return steps;
    }
    error.Add(bullet.motion(), command);
  }
  return steps;
}
#endif

void PhysicsContact(benchmark::State& state, const std::string& name) {
  const auto scene = LoadScene(name, {"environment.speed_disturbance=0", "environment.yaw_rate_disturbance=0"});
  const std::vector<Tape> tapes = RecordTapes(scene, kTapes);
  PhysicsAndContact physics(*scene);
  double seconds = 0;
  int64_t steps = 0;
  size_t next = 0;
#ifdef CAIRN_BENCH_BULLET
  BulletScene bullet(*scene, static_cast<int>(state.range(0)));
  double bullet_seconds = 0;
  SpeedError bullet_error(scene->experiment().vehicle);
  int64_t bullet_steps = 0;
#endif
  for (auto _ : state) {
    const Tape& tape = tapes[next++ % tapes.size()];
    const double start = ThreadCpuSeconds();
    steps += physics.Play(tape);
    const double middle = ThreadCpuSeconds();
    seconds += middle - start;
    state.SetIterationTime(middle - start);
#ifdef CAIRN_BENCH_BULLET
    bullet_steps += PlayInBullet(bullet, *scene, tape, bullet_error);
    bullet_seconds += ThreadCpuSeconds() - middle;
#endif
  }
  const double rate = static_cast<double>(steps) / seconds;
  state.counters["steps_per_s"] = rate;
  state.counters["speed_error"] = physics.speed_error().rms();
#ifdef CAIRN_BENCH_BULLET
  const double bullet_rate = static_cast<double>(bullet_steps) / bullet_seconds;
  state.counters["bullet_steps_per_s"] = bullet_rate;
  state.counters["ratio_to_bullet"] = rate / bullet_rate;
  state.counters["speed_error_in_bullet"] = bullet_error.rms();
#endif
}
BENCHMARK_CAPTURE(PhysicsContact, quadrotor, "quadrotor_maze")
    ->Arg(10)
    ->UseManualTime()
    ->Name("physics_contact/quadrotor");
BENCHMARK_CAPTURE(PhysicsContact, wheeled_car, "car_maze")
    ->Arg(10)
    ->Arg(50)
    ->UseManualTime()
    ->Name("physics_contact/wheeled_car");
// With fewer than 500 iterations Bullet's quadruped does not keep standing.
BENCHMARK_CAPTURE(PhysicsContact, quadruped, "quadruped_maze")
    ->Arg(10)
    ->Arg(50)
    ->Arg(500)
    ->UseManualTime()
    ->Name("physics_contact/quadruped");

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

void FullStep(benchmark::State& state, const std::string& name) {
  const auto scene = LoadScene(name);
  const std::vector<Tape> tapes = RecordTapes(scene, kTapes);
  PhysicsAndContact physics(*scene);
  Environment environment(scene);
  std::vector<float> observation(static_cast<size_t>(ObservationSize(scene->experiment())));
  double physics_seconds = 0, seconds = 0;
  int64_t steps = 0;
  size_t next = 0;
  for (auto _ : state) {
    const Tape& tape = tapes[next++ % tapes.size()];
    const double start = ThreadCpuSeconds();
    physics.Play(tape);
    const double middle = ThreadCpuSeconds();
    steps += PlayFull(environment, tape, observation);
    const double end = ThreadCpuSeconds();
    physics_seconds += middle - start;
    seconds += end - middle;
    state.SetIterationTime(end - middle);
  }
  state.counters["env_steps_per_s"] = static_cast<double>(steps) / seconds;
  state.counters["ratio"] = physics_seconds / seconds;
}
BENCHMARK_CAPTURE(FullStep, quadrotor, "quadrotor_maze")->UseManualTime()->Name("full_step/quadrotor");
BENCHMARK_CAPTURE(FullStep, wheeled_car, "car_maze")->UseManualTime()->Name("full_step/wheeled_car");
BENCHMARK_CAPTURE(FullStep, quadruped, "quadruped_maze")->UseManualTime()->Name("full_step/quadruped");

// Work done a second by `threads` threads together, each with a `work` of its own that returns how much it did.
using Work = std::function<double()>;
double RateTogether(const std::vector<Work>& works, size_t threads) {
  std::vector<double> rates(threads, 0);
  {
    std::vector<std::jthread> running;
    for (size_t i = 0; i < threads; ++i) {
      running.emplace_back([&rates, &works, i] {
        const TimePoint start = Clock::now();
        double done = 0;
        do {
          done += works[i]();
        } while (SecondsSince(start) < kTurn);
        rates[i] = done / SecondsSince(start);
      });
    }
  }
  double sum = 0;
  for (const double rate : rates) sum += rate;
  return sum;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void TwoActors(benchmark::State& state, const std::string& name) {
  const auto scene = LoadScene(name);
  const std::vector<Tape> tapes = RecordTapes(scene, kTapes);
  std::deque<Environment> environments;
  std::vector<std::vector<float>> observations(2);
  std::vector<size_t> next(2, 0);
  std::vector<FmaPeak> peaks(2, FmaPeak("hsw"));
  std::vector<Work> actors, loops;
  for (size_t i = 0; i < 2; ++i) {
    environments.emplace_back(scene);
    observations[i].resize(static_cast<size_t>(ObservationSize(scene->experiment())));
  }
  for (size_t i = 0; i < 2; ++i) {
    actors.emplace_back([&, i] {
      return static_cast<double>(PlayFull(environments[i], tapes[next[i]++ % tapes.size()], observations[i]));
    });
    loops.emplace_back([&, i] { return peaks[i].Run(1e7); });
  }
  std::vector<double> actor_scaling, loop_scaling, ratios;
  for (auto _ : state) {
    const double one_actor = RateTogether(actors, 1), one_loop = RateTogether(loops, 1);
    const double two_actors = RateTogether(actors, 2), two_loops = RateTogether(loops, 2);
    actor_scaling.push_back(two_actors / one_actor);
    loop_scaling.push_back(two_loops / one_loop);
    ratios.push_back(actor_scaling.back() / loop_scaling.back());
  }
  state.counters["actors_two_over_one"] = Median(actor_scaling);
  state.counters["loops_two_over_one"] = Median(loop_scaling);
  state.counters["ratio"] = Median(ratios);
}
BENCHMARK_CAPTURE(TwoActors, quadrotor, "quadrotor_maze")->UseRealTime()->Iterations(25)->Name("two_actors/quadrotor");
BENCHMARK_CAPTURE(TwoActors, wheeled_car, "car_maze")->UseRealTime()->Iterations(25)->Name("two_actors/wheeled_car");

}  // namespace
}  // namespace cairn::actors

BENCHMARK_MAIN();
