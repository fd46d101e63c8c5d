#include "common/config/process_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/lcm_url.h"
#include "common/core/check.h"

namespace cairn {
namespace {

using testing::HasSubstr;

std::optional<ProcessOptions> Parse(ProcessKind kind, const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"cairn-process"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  return ParseProcessOptions(kind, static_cast<int>(argv.size()), argv.data());
}

std::string ErrorOf(ProcessKind kind, const std::vector<std::string>& arguments) {
  try {
    Parse(kind, arguments);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "no error";
}

ProcessOptions Full() {
  ProcessOptions options;
  options.experiment = "/tmp/run/experiment.textproto";
  options.run_dir = "/tmp/run dir";
  options.run_id = 0x7fedcba987654321;
  options.transport = TransportConfig{"239.1.2.3", 7705, 1};
  options.key = "/tmp/run/key";
  options.parent_fd = 5;
  options.log_level = "debug";
  return options;
}

TEST(ProcessOptionsTest, ArgumentsReadBackToTheSameOptions) {
  ProcessOptions options = Full();
  options.actors = 3;
  options.launch_utime_us = 123456789;
  options.replay_log = "/tmp/run log";
  options.replay_key = "/tmp/key";
  const auto learner = Parse(ProcessKind::kLearner, ToArguments(ProcessKind::kLearner, options));
  ASSERT_TRUE(learner.has_value());
  EXPECT_EQ(learner->experiment, options.experiment);
  EXPECT_EQ(learner->run_dir, options.run_dir);
  EXPECT_EQ(learner->run_id, options.run_id);
  EXPECT_EQ(learner->transport, options.transport);
  EXPECT_EQ(learner->key, options.key);
  EXPECT_FALSE(learner->insecure);
  EXPECT_EQ(learner->parent_fd, 5);
  EXPECT_EQ(learner->log_level, "debug");
  EXPECT_EQ(learner->actors, 3);
  EXPECT_EQ(learner->launch_utime_us, 123456789);
  EXPECT_EQ(learner->replay_log, "/tmp/run log");
  EXPECT_EQ(learner->replay_key, "/tmp/key");
}

TEST(ProcessOptionsTest, ActorHasIdAndGeneration) {
  ProcessOptions options = Full();
  options.actor_id = 4;
  options.generation = 2;
  const auto actor = Parse(ProcessKind::kActor, ToArguments(ProcessKind::kActor, options));
  ASSERT_TRUE(actor.has_value());
  EXPECT_EQ(actor->actor_id, 4);
  EXPECT_EQ(actor->generation, 2);
}

TEST(ProcessOptionsTest, ExperimentMayBeAPositionalOrAnOption) {
  for (const std::vector<std::string>& file :
       {std::vector<std::string>{"f.textproto"}, {"--experiment", "f.textproto"}}) {
    std::vector<std::string> arguments{"--run-id", "5eed", "--insecure"};
    arguments.insert(arguments.begin(), file.begin(), file.end());
    const auto actor = Parse(ProcessKind::kActor, arguments);
    ASSERT_TRUE(actor.has_value());
    EXPECT_EQ(actor->experiment, "f.textproto");
    EXPECT_TRUE(actor->insecure);
    EXPECT_FALSE(actor->transport);
  }
}

TEST(ProcessOptionsTest, WrongArgumentsAreNamed) {
  EXPECT_THAT(ErrorOf(ProcessKind::kPlanner, {"--run-id", "1"}), HasSubstr("experiment file is missing"));
  EXPECT_THAT(ErrorOf(ProcessKind::kPlanner, {"f", "--run-id", "xyz"}), HasSubstr("--run-id xyz"));
  EXPECT_THAT(ErrorOf(ProcessKind::kPlanner, {"f", "--run-id", "0"}), HasSubstr("--run-id 0"));
  EXPECT_THAT(ErrorOf(ProcessKind::kActor, {"f", "--run-id", "1", "--actorid", "2"}),
              HasSubstr("nearest known one is --actor-id"));
  EXPECT_THAT(ErrorOf(ProcessKind::kActor, {"f", "--run-id", "1", "--lcm-url", "http://localhost:7700"}),
              HasSubstr("--lcm-url http://localhost:7700"));
  EXPECT_THAT(ErrorOf(ProcessKind::kActor, {"f", "--run-id", "1", "--key", "k", "--insecure"}),
              HasSubstr("--insecure: it does not go with --key"));
  EXPECT_THAT(ErrorOf(ProcessKind::kActor, {"f", "--experiment", "g", "--run-id", "1"}), HasSubstr("--experiment"));
}

ProcessOptions CarMaze(const TransportConfig& transport) {
  ProcessOptions options;
  options.experiment = CAIRN_SOURCE_DIR "/deploy/experiments/car_maze.textproto";
  options.transport = transport;
  return options;
}

TEST(ProcessOptionsTest, TransportOfTheCommandLineWins) {
  const TransportConfig transport{"239.1.2.3", 9100, 0};
  EXPECT_EQ(LoadProcessExperiment(CarMaze(transport)).experiment.transport, transport);
  ProcessOptions options = CarMaze(transport);
  options.transport.reset();
  EXPECT_EQ(LoadProcessExperiment(options).experiment.transport, TransportConfig());
}

TEST(ProcessOptionsTest, OtherHostsNeedAKeyOrInsecure) {
  ProcessOptions options = CarMaze({"239.1.2.3", 9100, 1});
  try {
    LoadProcessExperiment(options);
    FAIL();
  } catch (const UsageError& error) {
    for (const char* word : {"ttl 1", "--key FILE", "--insecure"}) EXPECT_THAT(error.what(), HasSubstr(word));
  }
  options.insecure = true;
  EXPECT_NO_THROW(LoadProcessExperiment(options));
  options.insecure = false;
  options.key = "key";
  EXPECT_NO_THROW(LoadProcessExperiment(options));
}

TEST(ProcessOptionsTest, BrokersElsewhereNeedAKeyToo) {
  ProcessOptions options = CarMaze(ParseLcmUrl("tcpq://node1:7700"));
  try {
    LoadProcessExperiment(options);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("tcpq://node1:7700: other hosts can send to this run"));
  }
  options.transport = ParseLcmUrl("tcpq://localhost:7700");
  EXPECT_NO_THROW(LoadProcessExperiment(options));
}

}  // namespace
}  // namespace cairn
