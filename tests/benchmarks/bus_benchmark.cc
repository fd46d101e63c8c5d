// Cost of the wire format per transition: encode, frame, check and decode of experience messages, beside a plain copy
// of the same floats in the same run.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstring>

#include "common/bus/codec.h"
#include "common/bus/frame.h"

namespace cairn {
namespace {

constexpr int kObservation = 25;
constexpr int kAction = 2;

// `segments` of ten steps of the car.
Experience MakeExperience(int segments) {
  Experience m;
  m.session = 1;
  m.sequence = 1;
  m.observation_size = kObservation;
  m.action_size = kAction;
  for (int i = 0; i < segments; ++i) {
    Segment s;
    s.vehicle = i;
    s.observations.assign(11 * kObservation, 0.5f);
    s.actions.assign(10 * kAction, 0.25f);
    s.rewards.assign(10, 1.0f);
    m.segments.push_back(s);
  }
  return m;
}

double Seconds(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void Report(benchmark::State& state, int segments, double work_s, double copy_s) {
  const double transitions = static_cast<double>(state.iterations()) * segments * 10;
  state.counters["transitions_per_s"] = transitions / work_s;
  state.counters["ratio_to_copy"] = work_s / copy_s;
}

void Encode(benchmark::State& state) {
  const int segments = static_cast<int>(state.range(0));
  const Experience message = MakeExperience(segments);
  const Bytes reference = Encode(message);
  Bytes copy(reference.size());
  double work_s = 0, copy_s = 0;
  for (auto _ : state) {
    auto start = std::chrono::steady_clock::now();
    Bytes bytes = Encode(message);
    SealFrame(1, {1, 1}, &bytes);
    benchmark::DoNotOptimize(bytes.data());
    work_s += Seconds(start);
    start = std::chrono::steady_clock::now();
    std::memcpy(copy.data(), reference.data(), reference.size());
    benchmark::DoNotOptimize(copy.data());
    benchmark::ClobberMemory();
    copy_s += Seconds(start);
  }
  Report(state, segments, work_s, copy_s);
}
BENCHMARK(Encode)->Name("codec/encode")->Arg(1)->Arg(8)->Arg(32);

void DecodeFrame(benchmark::State& state) {
  const int segments = static_cast<int>(state.range(0));
  Bytes frame = Encode(MakeExperience(segments));
  SealFrame(1, {1, 1}, &frame);
  Bytes copy(frame.size());
  double work_s = 0, copy_s = 0;
  for (auto _ : state) {
    auto start = std::chrono::steady_clock::now();
    const OpenedFrame opened = OpenFrame(frame, 1);
    auto message = Decode<Experience>(opened.message);
    benchmark::DoNotOptimize(message);
    work_s += Seconds(start);
    start = std::chrono::steady_clock::now();
    std::memcpy(copy.data(), frame.data(), frame.size());
    benchmark::DoNotOptimize(copy.data());
    benchmark::ClobberMemory();
    copy_s += Seconds(start);
  }
  Report(state, segments, work_s, copy_s);
}
BENCHMARK(DecodeFrame)->Name("codec/decode")->Arg(1)->Arg(8)->Arg(32);

}  // namespace
}  // namespace cairn

BENCHMARK_MAIN();
