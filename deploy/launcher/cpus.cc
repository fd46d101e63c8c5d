#include "deploy/launcher/cpus.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

namespace cairn::deploy {
namespace {

constexpr double kNoLimit = 1e9;

double AffinityCpus() {
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof(set), &set) == 0) return CPU_COUNT(&set);
  return std::max(1u, std::thread::hardware_concurrency());
}

// cgroup v2: "max 100000" or "<quota> <period>", on every level above us; a container shows its own as the root.
double QuotaV2(const std::string& directory) {
  std::ifstream file(directory + "/cpu.max");
  double quota = 0, period = 0;
  return file >> quota >> period && period > 0 ? quota / period : kNoLimit;
}

double QuotaV1(const std::string& directory) {
  std::ifstream quota_file(directory + "/cpu.cfs_quota_us"), period_file(directory + "/cpu.cfs_period_us");
  double quota = 0, period = 0;
  return quota_file >> quota && period_file >> period && quota > 0 && period > 0 ? quota / period : kNoLimit;
}

double CgroupCpus() {
  double cpus = std::min(QuotaV2("/sys/fs/cgroup"), QuotaV1("/sys/fs/cgroup/cpu"));
  std::ifstream self("/proc/self/cgroup");
  for (std::string line; std::getline(self, line);) {
    const size_t second = line.find(':', line.find(':') + 1);
    if (second == std::string::npos) continue;
    const bool v2 = line.compare(0, 3, "0::") == 0;
    if (!v2 && line.find("cpu") == std::string::npos) continue;
    std::string path = line.substr(second + 1);
    for (; path.size() > 1; path.erase(path.rfind('/'))) {
      cpus = std::min(cpus, v2 ? QuotaV2("/sys/fs/cgroup" + path) : QuotaV1("/sys/fs/cgroup/cpu" + path));
    }
  }
  return cpus;
}

double SlurmCpus() {
  const char* text = std::getenv("SLURM_CPUS_PER_TASK");
  const int cpus = text == nullptr ? 0 : std::atoi(text);
  return cpus > 0 ? cpus : kNoLimit;
}

}  // namespace

int AvailableCpus() {
  return std::max(1, static_cast<int>(std::floor(std::min({AffinityCpus(), CgroupCpus(), SlurmCpus()}))));
}

int DefaultActors(int num_vehicles) {
  const int cpus = AvailableCpus();
  return std::min(std::max(cpus - 1, std::min(2, cpus)), num_vehicles);
}

}  // namespace cairn::deploy
