// Whole runs over LCM's own broker (tcpq), which is killed in the middle and started again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <regex>

#include "common/core/check.h"
#include "tests/integration/run_cairn.h"
#include "tests/testing/lcm_broker.h"

namespace cairn::testing {
namespace {

using std::chrono::seconds;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

class BrokerRunTest : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!LcmBroker::Missing().empty()) GTEST_SKIP() << LcmBroker::Missing();
    broker_ = std::make_unique<LcmBroker>(22951);
    std::filesystem::create_directories(Dir("audit"));
  }

  std::filesystem::path Dir(const std::string& name) const { return directory_.path() / name; }

  std::vector<std::string> Arguments(const std::string& run, int64_t steps, const std::string& schedule) const {
    std::vector<std::string> arguments =
        SmallRun(Dir(run), steps, {"--actors", "2", "--set", "schedule=" + schedule, "--set", "transport.url=" + url_});
    arguments.erase(std::find(arguments.begin(), arguments.end(), "--quiet"));
    return arguments;
  }
  std::map<std::string, std::string> Audit() const { return {{"CAIRN_AUDIT_DIR", Dir("audit").string()}}; }
  std::string Log(const std::string& name) const { return ReadFile(Dir("run") / "log" / (name + ".log")); }

  TemporaryDirectory directory_;
  std::unique_ptr<LcmBroker> broker_;
  const std::string url_ = "tcpq://localhost:22951";
};

// The weights do not depend on what carries the messages.
TEST_F(BrokerRunTest, LockstepEndsWithTheBitsOfMulticast) {
  ASSERT_EQ(RunCairn(Arguments("run", 4000, "LOCKSTEP"), Dir("log"), Audit()), 0) << ReadFile(Dir("log"));
  const nlohmann::json summary = ReadJson(Dir("run") / "summary.json");
  EXPECT_EQ(summary["env_steps"], 4000);
  EXPECT_EQ(summary["transitions_lost"], 0);
  EXPECT_EQ(summary["deterministic"], true);
  ExpectReplayMatchesActors(Dir("audit"), 4000, false);
  ASSERT_EQ(RunCairn(SmallRun(Dir("udp"), 4000, {"--actors", "1"}), Dir("udp.log")), 0) << ReadFile(Dir("udp.log"));
  EXPECT_EQ(summary["weights_crc32c"], ReadJson(Dir("udp") / "summary.json")["weights_crc32c"]);
}

// All wait while it is away, longer than a silent actor is waited for, and say so; then they go on, nothing is lost.
TEST_P(BrokerRunTest, BrokerMayDieInMidRun) {
  std::vector<std::string> arguments = Arguments("run", 90000, GetParam());
  arguments.insert(arguments.end(), {"--set", "lockstep.actor_timeout_s=2"});
  Program train("cairn", arguments, Dir("log"), Audit());
  const auto made = [this] { return AuditLines(Dir("audit"), "learner").size(); };
  ASSERT_TRUE(WaitUntil(train, [&] { return made() > 3000; })) << ReadFile(Dir("log"));
  broker_->Kill();
  const std::regex away("no broker at tcpq://localhost:22951 for ([3-9]|[0-9]{2}) s .*: waiting");
  ASSERT_TRUE(WaitUntil(
      train, [&] { return std::regex_search(ReadFile(Dir("log")), away); }, seconds(30)))
      << ReadFile(Dir("log"));
  for (const char* process : {"learner", "planner", "actor-0", "actor-1"}) {
    EXPECT_TRUE(WaitUntil(train, [&] { return Log(process).find("waiting for it") != std::string::npos; }))
        << process << Log(process);
  }
  const size_t before = made();
  EXPECT_LT(before, 89000u);
  broker_->Start();
  EXPECT_TRUE(WaitUntil(
      train, [&] { return made() > before; }, seconds(20)))
      << ReadFile(Dir("log"));
  EXPECT_EQ(train.Wait(), 0) << ReadFile(Dir("log"));
  const nlohmann::json summary = ReadJson(Dir("run") / "summary.json");
  EXPECT_EQ(summary["transitions_lost"], 0);
  EXPECT_EQ(summary["env_steps"], 90000);
  EXPECT_EQ(summary["deterministic"], std::string(GetParam()) == "LOCKSTEP");
  EXPECT_THAT(Log("learner"), ContainsRegex("is back after"));
  ExpectReplayMatchesActors(Dir("audit"), 90000, false);
}

INSTANTIATE_TEST_SUITE_P(Schedules, BrokerRunTest, ::testing::Values("LOCKSTEP", "ASYNC"),
                         [](const auto& p) { return std::string(p.param); });

TEST_F(BrokerRunTest, MissingBrokerIsOneLineWithTheCommandThatStartsIt) {
  broker_->Kill();
  EXPECT_EQ(RunCairn(Arguments("run", 1000, "ASYNC"), Dir("log")), 1);
  EXPECT_THAT(
      ReadFile(Dir("log")),
      HasSubstr("transport.url = \"tcpq://localhost:22951\": no broker: Connection refused; start one: java -cp "
                "/usr/share/java/lcm.jar lcm.lcm.TCPService 22951"));
  EXPECT_FALSE(std::filesystem::exists(Dir("run")));
}

}  // namespace
}  // namespace cairn::testing
