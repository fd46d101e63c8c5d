// How many of the car's transitions a second one learner takes in from several processes: the real coordinator and
// replay buffer here, senders that stream made-up segments over the reliable stream as actors do. `raw` is plain LCM
// with the same messages, checked, decoded and put into the same replay buffer, but neither judged, acknowledged nor
// sent again: what does not arrive is gone. `cairn-bench-ingest sender …` is one sender. CAIRN_BENCH_HOSTS="h1 h2 …"
// starts sender i in the network namespace h_i.
#include <benchmark/benchmark.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "actors/experience_batcher.h"
#include "common/bus/bus.h"
#include "common/bus/reliable_stream.h"
#include "common/core/hash.h"
#include "common/core/version.h"
#include "learner/coordinator.h"
#include "learner/replay/replay_buffer.h"
#include "tests/benchmarks/cpu_time.h"

namespace cairn {
namespace {

constexpr int kCarActions = 2;  // speed and yaw rate

using std::chrono::milliseconds;

constexpr uint64_t kExperimentHash = 1;
constexpr int64_t kReplayRows = 500000;
constexpr int kSegmentSteps = 10;
constexpr int kEpisodeSteps = 300;
constexpr int kVehicles = 64;  // of each sender
constexpr int kMaxSenders = 64;

Experiment MakeExperiment(int ttl, int base_port, int64_t total, int senders) {
  Experiment e;
  e.schedule = Schedule::kAsync;
  e.num_vehicles = kVehicles * senders;
  e.total_env_steps = total;
  e.transport.ttl = ttl;
  e.transport.base_port = base_port;
  return e;
}

BusConfig MakeBusConfig(const Experiment& e, int64_t run_id) {
  return {e.transport.group, e.transport.base_port, e.transport.ttl, run_id, RandomId()};
}

// An actor without vehicles: it makes up the segments that its credit allows.
class Sender {
 public:
  Sender(const Experiment& experiment, int64_t run_id, int id, bool raw)
      : experiment_(experiment),
        id_(id),
        raw_(raw),
        bus_(MakeBusConfig(experiment, run_id)),
        stream_(
            [this](const Bytes& message) { bus_.PublishBytes(Plane::kExperience, ExperienceChannel(id_), message); }) {
    bus_.Subscribe<Welcome>(Plane::kControl, kWelcomeChannel, [this](const Welcome& w, const FrameInfo&) {
      if (w.session == bus_.config().session && w.status == Welcome::Status::kAccepted) welcome_ = w;
    });
    bus_.Subscribe<Control>(Plane::kControl, kControlChannel,
                            [this](const Control& c, const FrameInfo&) { OnControl(c); });
    next_step_.assign(kVehicles, 0);
  }

  void Run() {
    while (!control_ || control_->phase != Control::Phase::kFinished) {
      bus_.Poll(worked_ ? Duration::zero() : Duration(milliseconds(2)));
      const TimePoint now = Clock::now();
      worked_ = false;
      stream_.Poll(now);
      if (!welcome_) {
        Hello(now);
      } else if (control_ && control_->phase == Control::Phase::kRunning) {
        Status(now);
        Send(now);
      }
    }
  }

 private:
  void OnControl(const Control& control) {
    control_ = control;
    for (const Control::Actor& me : control.actors) {
      if (me.session != bus_.config().session) continue;
      credit_ = me.credit;
      stream_.Acknowledge({me.received, me.durable, me.window, me.echo_us, me.gaps}, Clock::now());
    }
  }

  void Hello(TimePoint now) {
    if (now < next_hello_ || !control_) return;
    next_hello_ = now + milliseconds(50);
    cairn::Hello hello;
    hello.session = bus_.config().session;
    hello.experiment_hash = kExperimentHash;
    hello.incarnation = control_->incarnation;
    hello.actor_id = id_;
    hello.observation_size = ObservationSize(experiment_);
    hello.git_revision = GitRevision();
    bus_.Publish(Plane::kExperience, kHelloChannel, hello);
  }

  void Status(TimePoint now) {
    if (now - last_status_ < milliseconds(20)) return;
    last_status_ = now;
    ActorStatus status;
    status.session = bus_.config().session;
    status.assignment = welcome_->assignment;
    status.last_sequence = stream_.last_sequence();
    status.sent = stream_.sent();
    status.resent = stream_.resent();
    status.round_trip_us = stream_.round_trip_us();
    status.actor_id = id_;
    bus_.Publish(Plane::kExperience, kStatusChannel, status);
  }

  // One round of all vehicles when the credit pays for it and not too much waits to go.
  void Send(TimePoint now) {
    const int max_bytes = MaxMessageBytes(experiment_.transport.ttl) - 200;
    if (!raw_ && (stream_.buffered_bytes() > 1 << 20 || made_ + kVehicles * kSegmentSteps > credit_)) return;
    std::vector<Segment> segments;
    for (const int32_t vehicle : welcome_->vehicle) segments.push_back(Make(vehicle));
    for (Experience& message :
         actors::PackExperience(std::move(segments), {}, {}, ObservationSize(experiment_), kCarActions, max_bytes)) {
      message.session = bus_.config().session;
      message.actor_id = id_;
      message.sequence = raw_ ? ++raw_sequence_ : stream_.next_sequence();
      if (raw_) {
        bus_.Publish(Plane::kExperience, ExperienceChannel(id_), message);
      } else {
        stream_.Push(Encode(message), now);
      }
    }
    made_ += kVehicles * kSegmentSteps;
    worked_ = true;
  }

  Segment Make(int32_t vehicle) {
    int64_t& step = next_step_[static_cast<size_t>(vehicle % kVehicles)];
    const auto observation = static_cast<size_t>(ObservationSize(experiment_));
    Segment s;
    s.vehicle = vehicle;
    s.episode = static_cast<int32_t>(step / kEpisodeSteps);
    s.first_step = static_cast<int32_t>(step % kEpisodeSteps);
    step += kSegmentSteps;
    s.end = step % kEpisodeSteps == 0 ? SegmentEnd::kTruncated : SegmentEnd::kNone;
    s.table_hash = control_->table_hash;
    s.policy_incarnation = control_->incarnation;
    s.policy_version = control_->policy_version;
    s.observations.assign((kSegmentSteps + 1) * observation, 0.5f);
    s.actions.assign(kSegmentSteps * kCarActions, 0.25f);
    s.rewards.assign(kSegmentSteps, 1.0f);
    return s;
  }

  const Experiment& experiment_;
  const int id_;
  const bool raw_;
  Bus bus_;
  ReliableSender stream_;
  std::optional<Welcome> welcome_;
  std::optional<Control> control_;
  std::vector<int64_t> next_step_;
  int64_t credit_ = 0;
  int64_t made_ = 0;
  int64_t raw_sequence_ = 0;
  bool worked_ = false;
  TimePoint next_hello_{};
  TimePoint last_status_{};
};

int RunSender(char** argv) {
  const Experiment experiment =
      MakeExperiment(std::atoi(argv[2]), std::atoi(argv[3]), std::atoll(argv[4]), std::atoi(argv[5]));
  Sender(experiment, std::atoll(argv[6]), std::atoi(argv[7]), std::string(argv[8]) == "raw").Run();
  return 0;
}

// The senders' processes, ended with their owner.
class Senders {
 public:
  Senders(const Experiment& e, int senders, int64_t run_id, bool raw) {
    std::vector<std::string> hosts;
    if (const char* names = std::getenv("CAIRN_BENCH_HOSTS")) {
      std::istringstream words(names);
      for (std::string word; words >> word;) hosts.push_back(word);
    }
    char self[4096] = {};
    if (readlink("/proc/self/exe", self, sizeof(self) - 1) < 0) std::abort();
    for (int id = 0; id < senders; ++id) {
      std::vector<std::string> words;
      if (!hosts.empty()) words = {"/usr/sbin/ip", "netns", "exec", hosts[static_cast<size_t>(id) % hosts.size()]};
      for (const std::string& word :
           {std::string(self), std::string("sender"), std::to_string(e.transport.ttl),
            std::to_string(e.transport.base_port), std::to_string(e.total_env_steps), std::to_string(senders),
            std::to_string(run_id), std::to_string(id), std::string(raw ? "raw" : "reliable")}) {
        words.push_back(word);
      }
      std::vector<char*> argv;
      for (std::string& word : words) argv.push_back(word.data());
      argv.push_back(nullptr);
      const pid_t pid = fork();
      if (pid == 0) {
        execv(argv[0], argv.data());
        _exit(127);
      }
      pids_.push_back(pid);
    }
  }

  ~Senders() {
    for (const pid_t pid : pids_) kill(pid, SIGKILL);
    for (const pid_t pid : pids_) waitpid(pid, nullptr, 0);
  }

 private:
  std::vector<pid_t> pids_;
};

// The planner's word that lets a fleet start.
void AnnounceTable(Bus* bus) {
  bus->Publish(Plane::kTables, kTableInfoChannel,
               TableInfo{.experiment_hash = kExperimentHash, .roadmap_hash = 8, .table_hash = 9});
}

learner::ReplayBuffer MakeReplay(const Experiment& e) {
  return {kReplayRows, ObservationSize(e), kCarActions, 3, 0.99};
}

struct Ingested {
  int64_t transitions = 0;
  double seconds = 0;
  double cpu_seconds = 0;
  learner::CoordinatorCounters counters;
};

// Takes in transitions for `seconds` after everybody has joined.
Ingested Ingest(const Experiment& experiment, int senders, double seconds) {
  const int64_t run_id = RandomId();
  Bus bus(MakeBusConfig(experiment, run_id));
  learner::ReplayBuffer replay = MakeReplay(experiment);
  learner::Coordinator coordinator(&bus, experiment, kExperimentHash, senders, 1);
  coordinator.Start();
  const Senders processes(experiment, senders, run_id, false);
  Bus planner(MakeBusConfig(experiment, run_id));
  AnnounceTable(&planner);
  std::jthread announcer([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      AnnounceTable(&planner);
      planner.Poll(milliseconds(50));
    }
  });
  if (!coordinator.WaitForFleet()) return {};
  announcer.request_stop();
  const std::vector<float> policy(1, 0.0f);
  coordinator.PublishPolicy(0, policy);
  Ingested result;
  constexpr int64_t kAhead = 400000;
  TimePoint start = Clock::now();
  double cpu = CpuSeconds(RUSAGE_SELF);
  int64_t first = -1;
  int64_t taken = 0;
  while (SecondsSince(start) < seconds) {
    coordinator.SetAllowed(taken + kAhead, false);
    for (const Segment& segment : coordinator.Take(milliseconds(5)).segments) taken += replay.Insert(segment);
    if (first < 0 && taken > 0) {
      first = taken;
      start = Clock::now();
      cpu = CpuSeconds(RUSAGE_SELF);
    }
  }
  result.seconds = SecondsSince(start);
  result.cpu_seconds = CpuSeconds(RUSAGE_SELF) - cpu;
  result.transitions = taken - first;
  result.counters = coordinator.counters();
  coordinator.Finish();
  return result;
}

// The same messages without anything around them.
Ingested IngestRaw(const Experiment& experiment, int senders, double seconds) {
  const int64_t run_id = RandomId();
  Bus bus(MakeBusConfig(experiment, run_id));
  learner::ReplayBuffer replay = MakeReplay(experiment);
  Ingested result;
  bus.Subscribe<Experience>(Plane::kExperience, kExperienceChannels, [&](const Experience& e, const FrameInfo&) {
    for (const Segment& segment : e.segments) result.transitions += replay.Insert(segment);
  });
  std::vector<Hello> joined;
  bus.Subscribe<Hello>(Plane::kExperience, kHelloChannel, [&](const Hello& hello, const FrameInfo&) {
    Welcome welcome;
    welcome.incarnation = 1;
    welcome.session = hello.session;
    welcome.assignment = 1;
    for (int v = 0; v < kVehicles; ++v) welcome.vehicle.push_back(hello.actor_id * kVehicles + v);
    welcome.next_episode.assign(kVehicles, 0);
    welcome.steps_done.assign(kVehicles, 0);
    welcome.state_bytes.assign(kVehicles, 0);
    bus.Publish(Plane::kControl, kWelcomeChannel, welcome);
    joined.push_back(hello);
  });
  bus.CheckPlanes();
  const Senders processes(experiment, senders, run_id, true);
  Control control;
  control.incarnation = 1;
  control.phase = Control::Phase::kRunning;
  TimePoint start = Clock::now();
  double cpu = CpuSeconds(RUSAGE_SELF);
  TimePoint announced{};
  bool running = false;
  while (!running || SecondsSince(start) < seconds) {
    if (Clock::now() - announced > milliseconds(20)) {
      announced = Clock::now();
      ++control.number;
      bus.Publish(Plane::kControl, kControlChannel, control);
    }
    bus.Poll(milliseconds(2));
    if (!running && static_cast<int>(joined.size()) >= senders) {
      running = true;
      result.transitions = 0;
      start = Clock::now();
      cpu = CpuSeconds(RUSAGE_SELF);
    }
  }
  result.seconds = SecondsSince(start);
  result.cpu_seconds = CpuSeconds(RUSAGE_SELF) - cpu;
  control.phase = Control::Phase::kFinished;
  for (int i = 0; i < 5; ++i) bus.Publish(Plane::kControl, kControlChannel, control);
  return result;
}

// Plain LCM and the reliable stream in turn.
void IngestBoth(benchmark::State& state, int ttl) {
  const int senders = static_cast<int>(state.range(0));
  constexpr double kSeconds = 2;
  Ingested reliable, raw;
  for (auto _ : state) {
    const Experiment experiment = MakeExperiment(ttl, 24000, int64_t{1} << 40, senders);
    raw = IngestRaw(experiment, senders, kSeconds);
    reliable = Ingest(experiment, senders, kSeconds);
  }
  const auto rate = [](const Ingested& i) { return static_cast<double>(i.transitions) / i.seconds; };
  const auto& counters = reliable.counters;
  state.counters["transitions_per_s"] = rate(reliable);
  state.counters["per_learner_cpu_s"] = static_cast<double>(reliable.transitions) / reliable.cpu_seconds;
  state.counters["raw_transitions_per_s"] = rate(raw);
  state.counters["ratio_to_raw"] = rate(reliable) / rate(raw);
  state.counters["lost"] = static_cast<double>(counters.transitions_lost);
  state.counters["duplicate"] = static_cast<double>(counters.transitions_duplicate);
  state.counters["resent_share"] =
      static_cast<double>(counters.messages_resent) / std::max<double>(1, static_cast<double>(counters.messages_sent));
}
BENCHMARK_CAPTURE(IngestBoth, long, 0)
    ->Name("ingest/60kB")
    ->Arg(4)
    ->Iterations(1)
    ->Unit(benchmark::kSecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(IngestBoth, short, 1)
    ->Name("ingest/1400B")
    ->Arg(4)
    ->Iterations(1)
    ->Unit(benchmark::kSecond)
    ->UseRealTime();

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  if (argc == 9 && std::string(argv[1]) == "sender") return cairn::RunSender(argv);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
