// What company costs: real actors, one or many, that share 64 vehicles and make the same 20,000 transitions a second
// together, beside the real coordinator and replay buffer here and a real planner. No gradient steps; new policies as
// often as the learner has them. company/N measures one actor and N in turn, CAIRN_BENCH_SECONDS each (default 5), as
// often as CAIRN_BENCH_ROUNDS says (default 3), and takes the medians, since other load on the machine comes and goes.
// Needs a multicast route: unshare -rn sh -c 'ip link set lo up; ip route add 224.0.0.0/4 dev lo; cairn-bench-company'
#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/config/load.h"
#include "common/config/process_options.h"
#include "common/core/check.h"
#include "common/core/hash.h"
#include "common/nn/policy_shape.h"
#include "learner/coordinator.h"
#include "learner/replay/replay_buffer.h"
#include "tests/benchmarks/cpu_time.h"

namespace cairn {
namespace {

constexpr int kCarActions = 2;  // speed and yaw rate

using std::chrono::milliseconds;

constexpr double kRate = 20000;  // transitions a second, of all together

// Programs of the build, ended with their owner.
class Programs {
 public:
  ~Programs() {
    for (const pid_t pid : pids_) kill(pid, SIGKILL);
    for (const pid_t pid : pids_) waitpid(pid, nullptr, 0);
  }

  void Start(ProcessKind kind, const ProcessOptions& options) {
    std::vector<std::string> words = ToArguments(kind, options);
    words.insert(words.begin(), std::string(CAIRN_BIN_DIR) + "/cairn-" + ProcessName(kind));
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

  // User and system time of all from the `first` on.
  double CpuSeconds(size_t first) const {
    double ticks = 0;
    for (size_t i = first; i < pids_.size(); ++i) {
      std::ifstream file("/proc/" + std::to_string(pids_[i]) + "/stat");
      std::string stat;
      std::getline(file, stat);
      std::istringstream fields(stat.substr(stat.rfind(')') + 2));
      std::string field;
      for (int skipped = 0; skipped < 11; ++skipped) fields >> field;
      double user = 0, system = 0;
      fields >> user >> system;
      ticks += user + system;
    }
    return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
  }

 private:
  std::vector<pid_t> pids_;
};

struct Measured {
  double transitions_per_s = 0;
  double learner_us = 0;  // CPU time for each transition
  double actors_us = 0;
  double ratio = 1;  // to one actor, measured just before
  double sum_us() const { return learner_us + actors_us; }
};

// The learner's loop of ASYNC with a clock in place of updates.
class Company {
 public:
  Company(const LoadedExperiment& loaded, const std::string& file, int actors)
      : experiment_(loaded.experiment),
        bus_({"239.255.76.67", 24100, 0, run_id_, RandomId(), std::nullopt}),
        replay_(500000, ObservationSize(experiment_), kCarActions, 3, 0.99),
        coordinator_(&bus_, experiment_, loaded.hash, actors, 1),
        parameters_(MakePolicyShape(experiment_).num_parameters(), 0.01f) {
    ProcessOptions options;
    options.experiment = file;
    options.run_id = run_id_;
    options.transport = TransportConfig{.group = "239.255.76.67", .base_port = 24100, .ttl = 0};
    options.log_level = "warning";
    programs_.Start(ProcessKind::kPlanner, options);
    for (; options.actor_id < actors; ++options.actor_id) programs_.Start(ProcessKind::kActor, options);
  }

  Measured Run(double seconds) {
    coordinator_.Start();
    coordinator_.StopWithin(std::chrono::seconds(60) +
                            std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds)));
    if (!coordinator_.WaitForFleet()) ThrowError("an actor did not come; is the machine too busy?");
    start_ = Clock::now();
    published_ = start_;
    while (taken_ < kRate * SecondsSince(start_) - 2000 && SecondsSince(start_) < 30) RunFor(0.5);  // who came late
    RunFor(1);
    const double learner = CpuSeconds(RUSAGE_SELF), actors = programs_.CpuSeconds(1);
    const int64_t before = taken_;
    const TimePoint begin = Clock::now();
    RunFor(seconds);
    const auto transitions = static_cast<double>(taken_ - before);
    const Measured measured{transitions / SecondsSince(begin), 1e6 * (CpuSeconds(RUSAGE_SELF) - learner) / transitions,
                            1e6 * (programs_.CpuSeconds(1) - actors) / transitions};
    coordinator_.Finish();
    return measured;
  }

 private:
  void RunFor(double seconds) {
    const TimePoint begin = Clock::now();
    while (SecondsSince(begin) < seconds) {
      coordinator_.SetAllowed(static_cast<int64_t>(kRate * SecondsSince(start_)), false);
      for (const Segment& segment : coordinator_.Take(milliseconds(5)).segments) taken_ += replay_.Insert(segment);
      if (Clock::now() - published_ < coordinator_.publish_interval()) continue;
      published_ = Clock::now();
      coordinator_.PublishPolicy(++version_, parameters_);
    }
  }

  const int64_t run_id_ = RandomId() & 0x7fffffff;
  const Experiment& experiment_;
  Bus bus_;
  learner::ReplayBuffer replay_;
  learner::Coordinator coordinator_;
  std::vector<float> parameters_;
  Programs programs_;
  TimePoint start_{};
  TimePoint published_{};
  int64_t version_ = 0;
  int64_t taken_ = 0;
};

double Setting(const char* name, double otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::atof(text);
}

double Median(const std::vector<Measured>& rounds, double Measured::*member) {
  std::vector<double> values;
  for (const Measured& round : rounds) values.push_back(round.*member);
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void CostOfCompany(benchmark::State& state) {
  const double seconds = Setting("CAIRN_BENCH_SECONDS", 5);
  const LoadedExperiment loaded =
      LoadExperiment(std::string(CAIRN_SOURCE_DIR) + "/deploy/experiments/car_maze_async.textproto",
                     {"vehicle.kind=PLANE_CAR", "num_vehicles=64", "total_env_steps=1000000000",
                      "learner.learning_starts=1000", "async.error_buffer=4000"});
  const std::string file = "/tmp/cairn-bench-company-" + std::to_string(getpid()) + ".textproto";
  std::ofstream(file) << loaded.resolved_text;
  std::vector<Measured> one, many;
  try {
    for (auto _ : state) {
      for (int round = 0; round < std::max(1.0, Setting("CAIRN_BENCH_ROUNDS", 3)); ++round) {
        one.push_back(Company(loaded, file, 1).Run(seconds));
        many.push_back(Company(loaded, file, static_cast<int>(state.range(0))).Run(seconds));
        many.back().ratio = many.back().sum_us() / one.back().sum_us();
      }
    }
  } catch (const Error& error) {
    state.SkipWithError(error.what());
    return;
  }
  std::filesystem::remove(file);
  state.counters["transitions_per_s"] = Median(many, &Measured::transitions_per_s);
  state.counters["learner_us"] = Median(many, &Measured::learner_us);
  state.counters["actors_us"] = Median(many, &Measured::actors_us);
  state.counters["one_learner_us"] = Median(one, &Measured::learner_us);
  state.counters["one_actors_us"] = Median(one, &Measured::actors_us);
  state.counters["ratio_to_one"] = Median(many, &Measured::ratio);
}
BENCHMARK(CostOfCompany)
    ->Name("company")
    ->Arg(1)
    ->Arg(4)
    ->Arg(16)
    ->Arg(64)
    ->Iterations(1)
    ->Unit(benchmark::kSecond)
    ->UseRealTime();

}  // namespace
}  // namespace cairn

BENCHMARK_MAIN();
