// Cost of the wire format per transition: encode, frame, check and decode of experience messages, beside a plain copy
// of the same floats in the same run.
#include <benchmark/benchmark.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <thread>

#include "common/bus/bus.h"
#include "common/bus/codec.h"
#include "common/bus/frame.h"
#include "common/bus/replay_window.h"
#include "common/core/check.h"
#include "common/core/hash.h"
#include "tests/testing/lcm_broker.h"

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
  const FrameSeal seal(1);
  double work_s = 0, copy_s = 0;
  for (auto _ : state) {
    auto start = std::chrono::steady_clock::now();
    Bytes bytes = Encode(message);
    seal.Seal(Plane::kExperience, {1, 1}, &bytes);
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
  const FrameSeal seal(1);
  seal.Seal(Plane::kExperience, {1, 1}, &frame);
  Bytes copy(frame.size());
  double work_s = 0, copy_s = 0;
  for (auto _ : state) {
    auto start = std::chrono::steady_clock::now();
    const OpenedFrame opened = seal.Open(Plane::kExperience, frame);
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

// Seal and open of one frame, keyed and plain in turn in the same run, so that noise hits both alike. `plain_ns` and
// `keyed_ns` are what sender and receiver pay together for a message; `ratio_to_plain` is keyed over plain.
void SealAndOpen(benchmark::State& state) {
  const Bytes message(static_cast<size_t>(state.range(0)) - kTrailerBytes, 7);
  const FrameSeal plain(1), sender(1, RunKey{1, 2, 3}, 1), receiver(1, RunKey{1, 2, 3}, 2);
  PeerContexts peers;
  Bytes frame;
  frame.reserve(message.size() + kTrailerBytes);
  ReplayGuard guard;
  uint64_t counter = 0;
  const auto once = [&](const FrameSeal& seal, const FrameSeal& open) {
    frame = message;
    const auto start = std::chrono::steady_clock::now();
    seal.Seal(Plane::kExperience, {1, ++counter}, &frame);
    OpenedFrame opened = open.Open(Plane::kExperience, frame, &peers);
    if (opened.fault || (seal.keyed() && !guard.Accept(Plane::kExperience, 1, counter))) state.SkipWithError("refused");
    benchmark::DoNotOptimize(opened);
    return Seconds(start);
  };
  double plain_s = 0, keyed_s = 0;
  for (auto _ : state) {
    plain_s += once(plain, plain);
    keyed_s += once(sender, receiver);
  }
  const double each = 1e9 / static_cast<double>(state.iterations());
  state.counters["plain_ns"] = plain_s * each;
  state.counters["keyed_ns"] = keyed_s * each;
  state.counters["ratio_to_plain"] = keyed_s / plain_s;
}
BENCHMARK(SealAndOpen)->Name("frame/seal_and_open")->Arg(1400)->Arg(8000)->Arg(60000);

// A sender and a receiver of one run over real LCM on this host, with as much outstanding as an actor may have.
class Stream {
 public:
  Stream(int base_port, int bytes, const std::optional<RunKey>& key, const std::string& broker = "")
      : sender_(Config(base_port, key, broker)), receiver_(Config(base_port, key, broker)), window_(1000000 / bytes) {
    // The echo's payload fills the message up to the size that is measured.
    message_ = Encode(Echo{1, 0});
    message_ = Encode(Echo{1, bytes - static_cast<int>(message_.size()) - static_cast<int>(kTrailerBytes)});
    receiver_.SubscribeBytes(Plane::kExperience, "BENCH", [this](ByteSpan, const FrameInfo&) { ++received_; });
    if (!broker.empty()) receiver_.CheckPlanes();  // a broker takes subscriptions up in its own time
  }

  /// Seconds that `messages` take from the first publish to the last arrival; 0 when one was lost.
  double Send(int64_t messages) {
    const int64_t goal = received_ + messages;
    const auto start = std::chrono::steady_clock::now();
    std::jthread publisher([&] {
      for (int64_t i = goal - messages; i < goal; ++i) {
        while (i - received_ >= window_) std::this_thread::yield();
        sender_.PublishBytes(Plane::kExperience, "BENCH", message_);
      }
    });
    while (received_ < goal && Seconds(start) < 10) receiver_.Poll(std::chrono::milliseconds(1));
    const bool complete = received_ >= goal;
    if (!complete) received_ = goal;  // lets the publisher end
    return complete ? Seconds(start) : 0;
  }

 private:
  static BusConfig Config(int base_port, const std::optional<RunKey>& key, const std::string& broker) {
    return {"239.255.76.67", base_port, 0, 1, RandomId(), key, broker};
  }

  Bus sender_, receiver_;
  int64_t window_;
  Bytes message_;
  std::atomic<int64_t> received_{0};
};

// Messages over LCM, plain and keyed in turn; `ratio_to_plain` is keyed over plain goodput. Needs a multicast route:
// unshare -rn sh -c 'ip link set lo up; ip route add 224.0.0.0/4 dev lo; cairn-bench-bus --benchmark_filter=goodput'
void Goodput(benchmark::State& state) {
  const int bytes = static_cast<int>(state.range(0));
  const int64_t messages = 30000000 / bytes;
  try {
    Stream plain(23000, bytes, std::nullopt), keyed(23010, bytes, RunKey{1, 2, 3});
    double plain_s = 0, keyed_s = 0;
    for (auto _ : state) {
      const double p = plain.Send(messages), k = keyed.Send(messages);
      if (p == 0 || k == 0) return state.SkipWithError("a message was lost");
      plain_s += p;
      keyed_s += k;
    }
    const double total = static_cast<double>(state.iterations() * messages);
    state.counters["plain_per_s"] = total / plain_s;
    state.counters["keyed_per_s"] = total / keyed_s;
    state.counters["ratio_to_plain"] = plain_s / keyed_s;
  } catch (const Error& error) {
    state.SkipWithError(error.what());
  }
}
BENCHMARK(Goodput)->Name("bus/goodput")->Arg(1400)->Arg(60000)->Unit(benchmark::kMillisecond)->UseRealTime();

// The same over multicast and over LCM's own broker in turn; `ratio_to_udpm` is goodput over that of multicast.
void GoodputOverBroker(benchmark::State& state) {
  const int bytes = static_cast<int>(state.range(0));
  const int64_t messages = 15000000 / bytes;
  if (!testing::LcmBroker::Missing().empty()) return state.SkipWithError(testing::LcmBroker::Missing().c_str());
  try {
    const testing::LcmBroker broker(23030);
    Stream udpm(23020, bytes, std::nullopt), tcpq(23020, bytes, std::nullopt, broker.address());
    double udpm_s = 0, tcpq_s = 0;
    for (auto _ : state) {
      const double u = udpm.Send(messages), t = tcpq.Send(messages);
      if (u == 0 || t == 0) return state.SkipWithError("a message was lost");
      udpm_s += u;
      tcpq_s += t;
    }
    const double total = static_cast<double>(state.iterations() * messages);
    state.counters["udpm_per_s"] = total / udpm_s;
    state.counters["tcpq_per_s"] = total / tcpq_s;
    state.counters["tcpq_MB_per_s"] = 1e-6 * bytes * total / tcpq_s;
    state.counters["ratio_to_udpm"] = udpm_s / tcpq_s;
  } catch (const Error& error) {
    state.SkipWithError(error.what());
  }
}
BENCHMARK(GoodputOverBroker)
    ->Name("bus/goodput_tcpq")
    ->Arg(1400)
    ->Arg(8000)
    ->Arg(60000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace cairn

BENCHMARK_MAIN();
