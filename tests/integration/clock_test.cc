// Wall clocks that jump by an hour, forwards and backwards, in every process of a run again and again: nothing but what
// people read may depend on them.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "tests/integration/run_cairn.h"

namespace cairn::testing {
namespace {

class ClockTest : public ::testing::Test {
 protected:
  void SetUp() override {
#ifndef CAIRN_CLOCK_SHIM
    GTEST_SKIP() << "nothing can be preloaded into a build with a sanitizer";
#endif
    std::filesystem::create_directories(Dir("audit"));
  }

  std::filesystem::path Dir(const std::string& name) const { return directory_.path() / name; }

  // Runs to the end with a jump at every other look at the clock (the planner looks seldom); returns the summary.
  nlohmann::json RunWithJumps(const std::vector<std::string>& arguments) const {
    std::map<std::string, std::string> environment{{"CAIRN_AUDIT_DIR", Dir("audit").string()},
                                                   {"CAIRN_CLOCK_JUMP_LOG", Dir("jumps").string()},
                                                   {"CAIRN_CLOCK_JUMP_CALLS", "2"}};
#ifdef CAIRN_CLOCK_SHIM
    environment["LD_PRELOAD"] = CAIRN_CLOCK_SHIM;
#endif
    EXPECT_EQ(RunCairn(arguments, Dir("output.log"), environment), 0) << ReadFile(Dir("output.log"));
    return ReadJson(Dir("run") / "summary.json");
  }

  // Each program was an hour ahead, an hour behind and right again.
  void ExpectJumps() const {
    std::map<std::string, std::set<long>> offsets;
    std::istringstream log(ReadFile(Dir("jumps")));
    std::string program;
    for (long offset = 0; log >> program >> offset;) offsets[program].insert(offset);
    for (const char* name : {"cairn-actor", "cairn-learner", "cairn-planner"}) {
      EXPECT_EQ(offsets[name], (std::set<long>{-3600, 0, 3600})) << name;
    }
  }

  TemporaryDirectory directory_;
};

TEST_F(ClockTest, LockstepGivesTheSameBitsWhenClocksJump) {
  ASSERT_EQ(RunCairn(SmallRun(Dir("undisturbed"), 6010, {"--actors", "2"}), Dir("output.log")), 0)
      << ReadFile(Dir("output.log"));
  const nlohmann::json undisturbed = ReadJson(Dir("undisturbed") / "summary.json");
  const nlohmann::json summary = RunWithJumps(SmallRun(Dir("run"), 6010, {"--actors", "2"}));
  ExpectJumps();
  EXPECT_EQ(summary["weights_crc32c"], undisturbed["weights_crc32c"]);
  EXPECT_EQ(summary["success_rate"], undisturbed["success_rate"]);
  EXPECT_EQ(summary["deterministic"], true);
  EXPECT_EQ(summary["transitions_lost"], 0);
  EXPECT_EQ(summary["transitions_duplicate"], 0);
  ExpectReplayMatchesActors(Dir("audit"), 6010, false);
}

// Nothing waits for an hour or is given up for having been silent that long, and no hour is in what is reported.
TEST_F(ClockTest, AsyncLosesNothingWhenClocksJump) {
  const nlohmann::json summary =
      RunWithJumps(SmallRun(Dir("run"), 20003, {"--actors", "2", "--set", "schedule=ASYNC"}));
  ExpectJumps();
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["env_steps"], 20003);
  EXPECT_EQ(summary["transitions_lost"], 0);
  EXPECT_EQ(summary["transitions_duplicate"], 0);
  EXPECT_GT(summary["wall_s"], 0);
  EXPECT_LT(summary["wall_s"], 3600);
  ExpectReplayMatchesActors(Dir("audit"), 20003, false);
}

}  // namespace
}  // namespace cairn::testing
