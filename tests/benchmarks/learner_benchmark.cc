// The learner's rates on one core: whole updates, replay and policy inference.
//
// `sac|td3/NET/BATCH` count as fraction_of_fma_peak = (FLOPs of the matrix products of one update) × updates a second /
// (FLOPs a second of a register-only loop of fused multiply-adds of the same width), where the policy's gradient counts
// through both critics, as the losses are written; fraction_executed counts only what runs. Both run in turns
// of a few milliseconds, timed by the thread's CPU clock, and the medians over the turns count, so that the ratio holds
// on a busy machine too. With -DCAIRN_BENCH_TORCH=ON the same update in libtorch takes its turns as well:
// ratio_to_torch is ours over that with libtorch's own optimiser, ratio_to_flat_torch over that with all parameters in
// one tensor.

#include <benchmark/benchmark.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/codec.h"
#include "common/bus/frame.h"
#include "common/core/check.h"
#include "common/core/random.h"
#include "common/nn/gemm.h"
#include "common/nn/policy.h"
#include "learner/algorithms/algorithm.h"
#include "learner/replay/replay_buffer.h"
#include "tests/benchmarks/fma_peak.h"
#ifdef CAIRN_BENCH_TORCH
#include "tests/benchmarks/torch_update.h"
#endif
#include "tests/learner/algorithms/pendulum_run.h"

namespace cairn::learner {
namespace {

constexpr int kObservations = 14;
constexpr int kActions = 3;
constexpr int kReplayRows = 100000;
constexpr double kPeakFlops = 1e8;  // of one turn of the peak loop: about a millisecond
#ifdef CAIRN_BENCH_TORCH
constexpr double kUpdateFlops = 4e9;  // of one turn of updates; the first of them refills what the other left cold
#else
constexpr double kUpdateFlops = 8e8;
#endif

double CpuSeconds() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double Median(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

LearnerConfig MakeConfig(LearnerConfig::Algorithm algorithm, int width, int batch_size) {
  LearnerConfig config;
  config.algorithm = algorithm;
  config.net_arch = {width, width};
  config.batch_size = batch_size;
  config.target_entropy = -kActions;
  return config;
}

PolicyShape MakeShape(const LearnerConfig& config, int observations, int actions) {
  PolicyShape shape;
  shape.head = config.algorithm == LearnerConfig::Algorithm::kSac ? PolicyShape::Head::kGaussian
                                                                  : PolicyShape::Head::kDeterministic;
  shape.observation_size = observations;
  shape.action_size = actions;
  shape.net_arch = config.net_arch;
  return shape;
}

Segment RandomSegment(int steps, int observations, int actions, uint32_t index) {
  RandomStream random(1, RandomPurpose::kTest, index);
  Segment segment;
  segment.observations.resize(static_cast<size_t>(steps + 1) * observations);
  segment.actions.resize(static_cast<size_t>(steps) * actions);
  segment.rewards.resize(steps);
  for (auto* values : {&segment.observations, &segment.actions, &segment.rewards}) {
    for (float& v : *values) v = static_cast<float>(random.Uniform(-1.0, 1.0));
  }
  return segment;
}

std::unique_ptr<ReplayBuffer> FullReplay() {
  auto replay = std::make_unique<ReplayBuffer>(kReplayRows, kObservations, kActions, 3, 0.99);
  while (replay->num_inserted() < kReplayRows) {
    replay->Insert(RandomSegment(100, kObservations, kActions, static_cast<uint32_t>(replay->num_inserted())));
  }
  return replay;
}

/// Multiply-adds of the matrix products of one network and one sample.
struct Products {
  double forward = 0;   // all layers
  double backward = 0;  // Wᵀ dz of all layers but the first
  double first = 0;     // of the first layer, per input

  Products(int inputs, const std::vector<int>& net_arch, int outputs) {
    int in = inputs;
    std::vector<int> sizes = net_arch;
    sizes.push_back(outputs);
    for (int out : sizes) {
      forward += static_cast<double>(in) * out;
      in = out;
    }
    first = sizes.front();
    backward = forward - first * inputs;
  }
};

/// Multiply-adds of one update and sample. With `both` SAC's policy gradient is counted through both critics, as its
/// loss is written and other libraries compute it; otherwise through the smaller one, which is what runs.
double MultiplyAdds(const LearnerConfig& config, const PolicyShape& shape, bool both) {
  const Products policy(shape.observation_size, shape.net_arch, shape.output_size());
  const Products critic(shape.observation_size + shape.action_size, shape.net_arch, 1);
  const double train_policy = 2 * policy.forward + policy.backward;  // forward, dW, dX
  const double train_critic = 2 * critic.forward + critic.backward;
  const double to_action = critic.backward + critic.first * shape.action_size;
  const double target = policy.forward + 2 * critic.forward;
  if (config.algorithm == LearnerConfig::Algorithm::kSac) {
    return target + 2 * train_critic + train_policy + 2 * critic.forward + (both ? 2 : 1) * to_action;
  }
  return target + 2 * train_critic + (train_policy + critic.forward + to_action) / config.policy_delay;
}

void BM_Update(benchmark::State& state, LearnerConfig::Algorithm kind, int width, int batch_size) {
  const LearnerConfig config = MakeConfig(kind, width, batch_size);
  const PolicyShape shape = MakeShape(config, kObservations, kActions);
  const auto algorithm = MakeAlgorithm(config, shape, 1);
  const std::unique_ptr<ReplayBuffer> full = FullReplay();
  const ReplayBuffer& replay = *full;
  FmaPeak peak(GemmTarget());
  const double update_flops = 2.0 * MultiplyAdds(config, shape, true) * batch_size;
  const int turn = 2 * (1 + static_cast<int>(kUpdateFlops / update_flops / 2));  // even: TD3's policy delay
  algorithm->Update(replay, 4, 0.0);
  peak.Run(kPeakFlops);

#ifdef CAIRN_BENCH_TORCH
  TorchUpdate torch(TorchStyle::kPlain, config, shape, replay), flat_torch(TorchStyle::kFlat, config, shape, replay);
  torch.Update(4);
  flat_torch.Update(4);
  std::vector<double> torch_rates, flat_torch_rates;
#endif
  std::vector<double> peak_rates, rates;
  for (auto _ : state) {
    const double start = CpuSeconds();
    const double peak_flops = peak.Run(kPeakFlops);
    const double middle = CpuSeconds();
    algorithm->Update(replay, turn, 0.0);
    const double end = CpuSeconds();
    peak_rates.push_back(peak_flops / (middle - start));
    rates.push_back(turn / (end - middle));
    state.SetIterationTime(end - middle);
#ifdef CAIRN_BENCH_TORCH
    torch.Update(turn);
    const double torch_end = CpuSeconds();
    flat_torch.Update(turn);
    torch_rates.push_back(turn / (torch_end - end));
    flat_torch_rates.push_back(turn / (CpuSeconds() - torch_end));
#endif
  }
  const double peak_rate = Median(&peak_rates);
  const double rate = Median(&rates);
  const double executed_flops = 2.0 * MultiplyAdds(config, shape, false) * batch_size;
  state.counters["updates_per_s"] = rate;
  state.counters["fraction_of_fma_peak"] = rate * update_flops / peak_rate;
  state.counters["fraction_executed"] = rate * executed_flops / peak_rate;
  state.counters["peak_gflops"] = peak_rate * 1e-9;
  state.counters["mflop_per_update"] = update_flops * 1e-6;
  std::string label = GemmTarget() + ", " + std::to_string(peak.width()) + "-bit peak";
#ifdef CAIRN_BENCH_TORCH
  for (const TorchUpdate* other : {&torch, &flat_torch}) {
    CAIRN_CHECK(std::isfinite(other->critic_loss()), "libtorch's critic loss is {}", other->critic_loss());
  }
  const double torch_rate = Median(&torch_rates);
  state.counters["torch_updates_per_s"] = torch_rate;
  state.counters["ratio_to_torch"] = rate / torch_rate;
  state.counters["ratio_to_flat_torch"] = rate / Median(&flat_torch_rates);
  label += ", " + TorchVersion();
#endif
  state.SetLabel(label);
}

/// Memory of this process that is in use [bytes].
double ResidentBytes() {
  std::ifstream statm("/proc/self/statm");
  double total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

/// What the learner does with experience: frames of eight segments of ten steps of the quadrotor are checked, decoded
/// and inserted, with three-step returns, into a full ring of 500,000. `insert` alone leaves out frames.
void BM_Insert(benchmark::State& state, bool decode) {
  constexpr int kSteps = 10, kSegments = 8, kFrames = 32, kCapacity = 500000, kQuadrotorObservations = 27;
  const FrameSeal seal(1);
  std::vector<Bytes> frames;
  std::vector<Experience> messages(kFrames);
  for (Experience& message : messages) {
    message.session = message.sequence = 1;
    message.observation_size = kQuadrotorObservations;
    message.action_size = kActions;
    for (int i = 0; i < kSegments; ++i) {
      message.segments.push_back(RandomSegment(kSteps, kQuadrotorObservations, kActions,
                                               static_cast<uint32_t>(frames.size() * kSegments + i)));
    }
    frames.push_back(Encode(message));
    seal.Seal(Plane::kExperience, {1, 1}, &frames.back());
  }
  const double before = ResidentBytes();
  ReplayBuffer replay(kCapacity, kQuadrotorObservations, kActions, 3, 0.99);
  for (size_t i = 0; replay.num_inserted() < kCapacity; ++i) {
    for (const Segment& segment : messages[i % kFrames].segments) replay.Insert(segment);
  }
  state.counters["replay_mb"] = 1e-6 * (ResidentBytes() - before);
  size_t next = 0;
  for (auto _ : state) {
    const size_t i = next++ % kFrames;
    if (decode) {
      const auto message = Decode<Experience>(seal.Open(Plane::kExperience, frames[i]).message);
      CAIRN_CHECK(message.has_value());
      for (const Segment& segment : message->segments) replay.Insert(segment);
    } else {
      for (const Segment& segment : messages[i].segments) replay.Insert(segment);
    }
  }
  state.counters["insert_per_s"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * kSegments * kSteps, benchmark::Counter::kIsRate);
}

/// One call of Policy::Explore for as many vehicles.
void BM_Inference(benchmark::State& state) {
  const auto vehicles = static_cast<int>(state.range(0));
  const LearnerConfig config = MakeConfig(LearnerConfig::Algorithm::kSac, 64, 1);
  const PolicyShape shape = MakeShape(config, kObservations, kActions);
  Policy policy(shape, vehicles);
  RandomStream random(1, RandomPurpose::kTest);
  std::vector<float> parameters(shape.num_parameters());
  for (float& p : parameters) p = static_cast<float>(random.Uniform(-0.1, 0.1));
  policy.SetParameters(parameters);
  std::vector<float> observations(static_cast<size_t>(vehicles) * kObservations, 0.5f);
  std::vector<float> noise(static_cast<size_t>(vehicles) * kActions, 0.5f), actions(noise.size());
  for (auto _ : state) {
    policy.Explore(observations.data(), vehicles, noise.data(), 0.1f, actions.data());
    benchmark::DoNotOptimize(actions.data());
    benchmark::ClobberMemory();
  }
  state.counters["vehicles_per_s"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * vehicles, benchmark::Counter::kIsRate);
}

/// Updates by `threads` threads in turns with the same by one, timed by the wall clock: how much faster they are.
void BM_Threads(benchmark::State& state, LearnerConfig::Algorithm kind, int width, int batch_size, int threads) {
  LearnerConfig config = MakeConfig(kind, width, batch_size);
  const PolicyShape shape = MakeShape(config, kObservations, kActions);
  const auto alone = MakeAlgorithm(config, shape, 1);
  config.update_threads = threads;
  const auto team = MakeAlgorithm(config, shape, 1);
  const std::unique_ptr<ReplayBuffer> full = FullReplay();
  const ReplayBuffer& replay = *full;
  const int turn = 2 * (1 + static_cast<int>(kUpdateFlops / MultiplyAdds(config, shape, false) / batch_size / 4));
  using Clock = std::chrono::steady_clock;
  std::vector<double> alone_times, team_times;
  for (auto _ : state) {
    const auto start = Clock::now();
    alone->Update(replay, turn, 0.0);
    const auto middle = Clock::now();
    team->Update(replay, turn, 0.0);
    const auto end = Clock::now();
    alone_times.push_back(std::chrono::duration<double>(middle - start).count());
    team_times.push_back(std::chrono::duration<double>(end - middle).count());
    state.SetIterationTime(team_times.back());
  }
  const double team_time = Median(&team_times);
  state.counters["updates_per_s"] = turn / team_time;
  state.counters["speedup"] = Median(&alone_times) / team_time;
}

/// A whole run of SAC on Pendulum-v1 in one thread: 10,000 steps of environment, policy and replay, one update of
/// critics, policy and alpha a step.
void BM_Pendulum(benchmark::State& state) {
  constexpr int kSteps = 10000;
  const LearnerConfig config = PendulumSacConfig();
  const double updates = kSteps - config.learning_starts;
  const double flops = 2.0 * MultiplyAdds(config, PendulumShape(config), false) * config.batch_size * updates;
  FmaPeak peak(GemmTarget());
  std::vector<double> wall, cpu, ceiling, mean_return;
  uint64_t seed = 1;
  for (auto _ : state) {
    PendulumRun run(config, seed++);
    const double peak_start = CpuSeconds();
    const double peak_flops = peak.Run(10 * kPeakFlops);
    const double start = CpuSeconds();
    const auto wall_start = std::chrono::steady_clock::now();
    run.Train(kSteps);
    wall.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start).count());
    cpu.push_back(CpuSeconds() - start);
    ceiling.push_back(flops * (start - peak_start) / peak_flops);
    mean_return.push_back(run.MeanReturn(20));
    state.SetIterationTime(wall.back());
  }
  state.counters["critic_updates"] = updates;
  state.counters["actor_updates"] = updates;
  state.counters["wall_s"] = Median(&wall);
  state.counters["cpu_s"] = Median(&cpu);
  state.counters["gemm_ceiling_s"] = Median(&ceiling);
  state.counters["mean_return"] = Median(&mean_return);
}

void RegisterUpdates() {
  const struct { int width, batch_size; } sizes[] = {{64, 1024}, {64, 256}, {256, 256}};
  for (const auto& size : sizes) {
    for (const auto algorithm : {LearnerConfig::Algorithm::kSac, LearnerConfig::Algorithm::kTd3}) {
      const bool sac = algorithm == LearnerConfig::Algorithm::kSac;
      const std::string name = std::string(sac ? "sac/" : "td3/") + std::to_string(size.width) + "x" +
                               std::to_string(size.width) + "/" + std::to_string(size.batch_size);
      benchmark::RegisterBenchmark(
          name.c_str(),
          [algorithm, size](benchmark::State& state) { BM_Update(state, algorithm, size.width, size.batch_size); })
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
      benchmark::RegisterBenchmark(
          (name + "/threads:2").c_str(),
          [algorithm, size](benchmark::State& state) { BM_Threads(state, algorithm, size.width, size.batch_size, 2); })
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
  benchmark::RegisterBenchmark("pendulum/sac", BM_Pendulum)->UseManualTime()->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("replay/decode_insert", [](benchmark::State& state) { BM_Insert(state, true); });
  benchmark::RegisterBenchmark("replay/insert", [](benchmark::State& state) { BM_Insert(state, false); });
  benchmark::RegisterBenchmark("inference/64x64", BM_Inference)->Arg(1)->Arg(16)->Arg(64);
}

}  // namespace
}  // namespace cairn::learner

int main(int argc, char** argv) {
#ifdef CAIRN_BENCH_TORCH
  cairn::learner::UseBestTorchSettings(argv);
#endif
  cairn::learner::RegisterUpdates();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
