#include "deploy/launcher/cpus.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <cstdlib>

#include "tests/deploy/launcher/test_support.h"

namespace cairn::deploy {
namespace {

TEST(CpusTest, AtLeastOneAndNotMoreThanAffinity) {
  cpu_set_t set;
  ASSERT_EQ(sched_getaffinity(0, sizeof(set), &set), 0);
  EXPECT_GE(AvailableCpus(), 1);
  EXPECT_LE(AvailableCpus(), CPU_COUNT(&set));
}

TEST(CpusTest, AffinityLimits) {
  const int cpus = InChildProcess([] {
    cpu_set_t set, one;
    sched_getaffinity(0, sizeof(set), &set);
    CPU_ZERO(&one);
    for (int i = 0; i < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++i) {
      if (CPU_ISSET(i, &set)) CPU_SET(i, &one);
    }
    sched_setaffinity(0, sizeof(one), &one);
    return AvailableCpus();
  });
  EXPECT_EQ(cpus, 1);
}

TEST(CpusTest, SlurmLimits) {
  const int cpus = InChildProcess([] {
    setenv("SLURM_CPUS_PER_TASK", "1", 1);
    return AvailableCpus();
  });
  EXPECT_EQ(cpus, 1);
}

TEST(CpusTest, DefaultActorsLeaveOneCpuOfManyAndNeedAVehicleEach) {
  EXPECT_EQ(DefaultActors(1), 1);
  EXPECT_EQ(DefaultActors(1000), std::max(AvailableCpus() - 1, std::min(2, AvailableCpus())));
}

}  // namespace
}  // namespace cairn::deploy
