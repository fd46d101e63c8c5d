#include "common/config/process_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  options.group = "239.1.2.3";
  options.base_port = 7705;
  options.ttl = 0;
  options.parent_fd = 5;
  options.log_level = "debug";
  return options;
}

TEST(ProcessOptionsTest, ArgumentsReadBackToTheSameOptions) {
  ProcessOptions options = Full();
  options.actors = 3;
  options.launch_utime_us = 123456789;
  const auto learner = Parse(ProcessKind::kLearner, ToArguments(ProcessKind::kLearner, options));
  ASSERT_TRUE(learner.has_value());
  EXPECT_EQ(learner->experiment, options.experiment);
  EXPECT_EQ(learner->run_dir, options.run_dir);
  EXPECT_EQ(learner->run_id, options.run_id);
  EXPECT_EQ(learner->group, options.group);
  EXPECT_EQ(learner->base_port, 7705);
  EXPECT_EQ(learner->ttl, 0);
  EXPECT_EQ(learner->parent_fd, 5);
  EXPECT_EQ(learner->log_level, "debug");
  EXPECT_EQ(learner->actors, 3);
  EXPECT_EQ(learner->launch_utime_us, 123456789);
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

TEST(ProcessOptionsTest, WrongArgumentsAreNamed) {
  EXPECT_THAT(ErrorOf(ProcessKind::kPlanner, {"--run-id", "1"}), HasSubstr("--experiment"));
  EXPECT_THAT(ErrorOf(ProcessKind::kPlanner, {"--experiment", "f", "--run-id", "xyz"}), HasSubstr("--run-id xyz"));
  EXPECT_THAT(ErrorOf(ProcessKind::kPlanner, {"--experiment", "f", "--run-id", "0"}), HasSubstr("--run-id 0"));
  EXPECT_THAT(ErrorOf(ProcessKind::kActor, {"--experiment", "f", "--run-id", "1", "--actorid", "2"}),
              HasSubstr("nearest known one is --actor-id"));
  EXPECT_THAT(ErrorOf(ProcessKind::kActor, {"--experiment", "f", "--run-id", "1", "--base-port", "80"}),
              HasSubstr("--base-port"));
}

TEST(ProcessOptionsTest, TransportOfTheCommandLineWins) {
  ProcessOptions options;
  options.experiment = CAIRN_SOURCE_DIR "/deploy/experiments/car_maze.textproto";
  options.base_port = 9100;
  const Experiment experiment = LoadProcessExperiment(options).experiment;
  EXPECT_EQ(experiment.transport.base_port, 9100);
  EXPECT_EQ(experiment.transport.group, "239.255.76.67");
}

}  // namespace
}  // namespace cairn
