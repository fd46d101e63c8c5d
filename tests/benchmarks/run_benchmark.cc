// Whole runs of `cairn train` (the car's maze, LOCKSTEP, default number of actors): env steps and updates a second and
// the share of the run that each process spends on a core. CAIRN_BENCH_STEPS sets the length (default 50000).
#include <benchmark/benchmark.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/benchmarks/cpu_time.h"

namespace {

int Execute(const std::vector<std::string>& words) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const pid_t pid = fork();
  if (pid == 0) {
    execv(argv[0], argv.data());
    _exit(127);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void Train(benchmark::State& state, const char* experiment) {
  const char* steps = std::getenv("CAIRN_BENCH_STEPS");
  const std::string run_dir = "/tmp/cairn-bench-run-" + std::to_string(getpid());
  for (auto _ : state) {
    std::filesystem::remove_all(run_dir);
    const double cpu = cairn::CpuSeconds(RUSAGE_CHILDREN);
    if (Execute({std::string(CAIRN_BIN_DIR) + "/cairn", "train",
                 std::string(CAIRN_SOURCE_DIR) + "/deploy/experiments/" + experiment, "--run-dir", run_dir, "--quiet",
                 "--set", std::string("total_env_steps=") + (steps == nullptr ? "50000" : steps)}) != 0) {
      state.SkipWithError("cairn train failed");
      return;
    }
    const nlohmann::json summary = nlohmann::json::parse(std::ifstream(run_dir + "/summary.json"));
    const double wall = summary["wall_s"];
    state.counters["env_steps_per_s"] = summary["env_steps_per_s"].get<double>();
    state.counters["updates_per_s"] = summary["updates_per_s"].get<double>();
    state.counters["wall_s"] = wall;
    state.counters["cores_busy"] = (cairn::CpuSeconds(RUSAGE_CHILDREN) - cpu) / wall;
    state.counters["learner_core"] = summary["learner_cpu_s"].get<double>() / wall;
    state.counters["actors_cores"] =
        (cairn::CpuSeconds(RUSAGE_CHILDREN) - cpu - summary["learner_cpu_s"].get<double>()) / wall;
  }
  std::filesystem::remove_all(run_dir);
}
BENCHMARK_CAPTURE(Train, lockstep, "car_maze.textproto")
    ->Name("train/lockstep")
    ->Iterations(1)
    ->Unit(benchmark::kSecond);
BENCHMARK_CAPTURE(Train, async, "car_maze_async.textproto")
    ->Name("train/async")
    ->Iterations(1)
    ->Unit(benchmark::kSecond);

}  // namespace

BENCHMARK_MAIN();
