// Runs with ttl 1, as they span hosts: real processes, started by `cairn train` or one by one as on another host.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/integration/run_cairn.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;

const std::string kExperiment = std::string(CAIRN_SOURCE_DIR) + "/deploy/experiments/car_maze.textproto";

class OtherHostsTest : public ::testing::Test {
 protected:
  std::filesystem::path Dir(const std::string& name) const { return directory_.path() / name; }
  std::filesystem::path log() const { return Dir("output.log"); }

  // A small run that leaves a resolved experiment and a key behind.
  std::vector<std::string> Train(const std::string& name) const {
    std::vector<std::string> arguments{"train",    kExperiment, "--run-dir", Dir(name).string(),
                                       "--actors", "2",         "--quiet"};
    for (const std::string& set :
         {std::string("vehicle.kind=PLANE_CAR"), std::string("total_env_steps=1500"),
          std::string("learner.learning_starts=500"), std::string("learner.train_freq=10"),
          std::string("evaluation.interval_env_steps=1000"), std::string("evaluation.max_steps=60"),
          std::string("evaluation.test_starts=20"), std::string("transport.ttl=1")}) {
      arguments.insert(arguments.end(), {"--set", set});
    }
    return arguments;
  }

  // What is typed on a host: experiment and key as copied there.
  std::vector<std::string> Host(const std::vector<std::string>& own, const std::string& key) const {
    std::vector<std::string> arguments{(Dir("run") / "experiment.textproto").string(), "--lcm-url",
                                       "udpm://239.255.76.67:26000?ttl=1", "--run-id", "5eed"};
    if (key.empty()) {
      arguments.push_back("--insecure");
    } else {
      arguments.insert(arguments.end(), {"--key", key});
    }
    arguments.insert(arguments.end(), own.begin(), own.end());
    return arguments;
  }

  TemporaryDirectory directory_;
};

TEST_F(OtherHostsTest, KeyChangesNothingInTheResult) {
  ASSERT_EQ(RunCairn(Train("run"), log()), 0) << ReadFile(log());
  std::vector<std::string> insecure = Train("insecure");
  insecure.push_back("--insecure");
  ASSERT_EQ(RunCairn(insecure, log()), 0) << ReadFile(log());
  const nlohmann::json keyed = ReadJson(Dir("run") / "summary.json");
  EXPECT_EQ(keyed["weights_crc32c"], ReadJson(Dir("insecure") / "summary.json")["weights_crc32c"]);
  EXPECT_EQ(keyed["env_steps"], 1500);
  EXPECT_EQ(keyed["transitions_lost"], 0);
  EXPECT_TRUE(std::filesystem::exists(Dir("run") / "key"));
  EXPECT_FALSE(std::filesystem::exists(Dir("insecure") / "key"));
}

TEST_F(OtherHostsTest, ProcessesStartedOneByOneShareAKeyAndIgnoreWhoHasNone) {
  ASSERT_EQ(RunCairn(Train("run"), log()), 0) << ReadFile(log());
  const std::string key = (Dir("run") / "key").string();
  const Program keyless("cairn-actor", Host({"--actor-id", "0"}, ""), Dir("keyless.log"));
  const Program planner("cairn-planner", Host({}, key), Dir("planner.log"));
  Program learner("cairn-learner", Host({"--run-dir", Dir("again").string(), "--actors", "2"}, key),
                  Dir("learner.log"));
  Program first("cairn-actor", Host({"--actor-id", "0"}, key), Dir("first.log"));
  Program second("cairn-actor", Host({"--actor-id", "1"}, key), Dir("second.log"));
  EXPECT_EQ(learner.Wait(), 0) << ReadFile(Dir("learner.log"));
  EXPECT_EQ(first.Wait(), 0) << ReadFile(Dir("first.log"));
  EXPECT_EQ(second.Wait(), 0) << ReadFile(Dir("second.log"));
  EXPECT_EQ(ReadJson(Dir("again") / "summary.json")["weights_crc32c"],
            ReadJson(Dir("run") / "summary.json")["weights_crc32c"]);
  EXPECT_THAT(ReadFile(Dir("learner.log")),
              ::testing::ContainsRegex("refused a datagram on the [a-z]+ plane: sent without a key"));
}

TEST_F(OtherHostsTest, ForgottenOrOpenKeyIsOneLineAndExitCodeTwo) {
  const std::vector<std::string> common{kExperiment, "--lcm-url", "udpm://239.255.76.67:26000?ttl=1", "--run-id",
                                        "5eed"};
  EXPECT_EQ(Program("cairn-actor", common, Dir("none.log")).Wait(), 2);
  EXPECT_THAT(ReadFile(Dir("none.log")), HasSubstr("give --key FILE"));
  EXPECT_THAT(ReadFile(Dir("none.log")), HasSubstr("--insecure"));
  std::ofstream(Dir("key")) << std::string(64, '1') << "\n";
  chmod(Dir("key").c_str(), 0644);
  std::vector<std::string> arguments = common;
  arguments.insert(arguments.end(), {"--key", Dir("key").string()});
  EXPECT_EQ(Program("cairn-actor", arguments, Dir("open.log")).Wait(), 2);
  EXPECT_EQ(ReadFile(Dir("open.log")), "cairn-actor: error: key file " + Dir("key").string() +
                                           ": mode 0644; group and others must have no access: chmod 600 " +
                                           Dir("key").string() + "\n");
}

}  // namespace
}  // namespace cairn::testing
