#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tests/deploy/launcher/test_support.h"

// What a person can get wrong on the command line: exit code 2 and one line on stderr that names the thing.
namespace cairn::deploy {
namespace {

constexpr const char* kCarMaze = CAIRN_SOURCE_DIR "/deploy/experiments/car_maze.textproto";

struct BadInput {
  std::vector<std::string> arguments;
  std::vector<std::string> words;  // all of them in the line
};

class BadInputTest : public testing::Test {
 protected:
  void ExpectRefused(const BadInput& input, int exit_code = 2) {
    std::vector<std::string> command{CAIRN_PROGRAM};
    command.insert(command.end(), input.arguments.begin(), input.arguments.end());
    const ProgramResult result = RunProgram(command, {"DISPLAY"});
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_EQ(result.err.rfind("cairn: error: ", 0), 0u) << result.err;
    for (const std::string& word : input.words) EXPECT_THAT(result.err, testing::HasSubstr(word));
  }

  // `cairn train` on a text; nothing may be left behind.
  void ExpectTrainRefused(const std::string& text, const std::vector<std::string>& words) {
    WriteText(directory_ / "car.textproto", text);
    ExpectRefused({{"train", directory_ / "car.textproto", "--run-dir", directory_ / "run"}, words});
    EXPECT_FALSE(std::filesystem::exists(directory_ / "run"));
  }

  TemporaryDirectory directory_;
};

TEST_F(BadInputTest, CommandLine) {
  ExpectRefused({{}, {"subcommand"}});
  ExpectRefused({{"trian", kCarMaze}, {"trian", "train"}});
  ExpectRefused({{"train"}, {"file"}});
  ExpectRefused({{"train", kCarMaze, "--actor", "2"}, {"--actor", "--actors"}});
  ExpectRefused({{"train", kCarMaze, "--actors", "0"}, {"--actors", "0"}});
  ExpectRefused({{"train", kCarMaze, "--actors", "33"}, {"--actors 33", "num_vehicles = 32"}});
  ExpectRefused({{"train", kCarMaze, "--seed", "abc"}, {"seed=abc", "whole number"}});
  ExpectRefused({{"train", "/nonexistent.textproto"}, {"/nonexistent.textproto", "No such file"}});
  ExpectRefused({{"train", kCarMaze, "--max-restarts", "-1"}, {"-1 not in range 0 to", "see cairn train --help"}});
  ExpectRefused({{"train", kCarMaze, "--set", "seed=1\n2"}, {"seed=1?2"}});
  ExpectRefused({{"eval", directory_.path(), "--seed", "-1"}, {"-1 not in range 0 to"}});
  ExpectRefused({{"doctor", "--map", "/none"}, {"they go with an experiment file"}});
}

TEST_F(BadInputTest, OutputThatCannotBeWrittenIsNoSuccess) {
  const ProgramResult result = RunProgram({"/bin/sh", "-c", std::string(CAIRN_PROGRAM) + " --help > /dev/full"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, testing::HasSubstr("cannot write to standard output"));
}

// A learner started by hand does not begin anew over what another has learnt.
TEST_F(BadInputTest, ALearnerOverCheckpointsWantsResume) {
  std::filesystem::create_directories(directory_ / "run/checkpoints");
  WriteText(directory_ / "run/checkpoints/checkpoint-1.ckpt", "");
  const ProgramResult result =
      RunProgram({CAIRN_PROGRAM, "learner", kCarMaze, "--run-id", "5eed", "--run-dir", directory_ / "run"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, testing::HasSubstr("it holds checkpoints of a run; --resume goes on with it"));
}

TEST_F(BadInputTest, Maps) {
  const std::string navigate = CAIRN_SOURCE_DIR "/deploy/experiments/navigate.textproto";
  WriteText(directory_ / "m.yaml", "image: m.pgm\nresolution: 50\n");
  WriteText(directory_ / "room.map", "type octile\nheight 1\nwidth 3\nmap\n...\n");
  const std::string yaml = directory_ / "m.yaml", map = directory_ / "room.map";
  ExpectRefused({{"train", navigate, "--map", yaml, "--goal", "1,1"}, {"m.yaml:2: resolution = 50", "metres"}});
  ExpectRefused({{"train", navigate, "--map", map}, {"world.goal is missing", "--goal X,Y"}});
  ExpectRefused({{"train", navigate, "--map", map, "--goal", "1"}, {"--goal 1", "X,Y"}});
  ExpectRefused({{"train", navigate, "--map", map, "--goal", "-1,0.5"}, {"world.goal_point: x = -1 m"}});
  ExpectRefused({{"train", navigate, "--robot", "/none"}, {"--robot /none", "No such file"}});
  ExpectRefused({{"train", "--resume", "/none", "--goal", "1,1"}, {"--map, --robot, --goal or --start"}});
  std::string tree = "# Octomap OcTree binary file\nid OcTree\nsize 17\nres 0.05\ndata\n";
  for (int level = 0; level < 15; ++level) tree += std::string("\x03\x00", 2);
  WriteText(directory_ / "a.bt", tree + "UU");  // eight free voxels
  ExpectRefused({{"train", navigate, "--map", directory_ / "a.bt", "--goal", "-1638.35,-1638.35,-1638.35"},
                 {"but the world is in space; world.slice_min", "world.slice_min"}});
}

TEST_F(BadInputTest, Experiment) {
  ExpectTrainRefused("learner { batchsize: 3 }", {"car.textproto:1", "learner.batchsize", "learner.batch_size"});
  ExpectTrainRefused("learner { batch_size: many }", {"car.textproto:1", "learner.batch_size", "many"});
  ExpectTrainRefused("learner { gamma: nan }", {"learner.gamma = nan"});
  ExpectTrainRefused("\n\nnum_vehicles: 0", {"car.textproto:3", "num_vehicles = 0", "[1, 65536]"});
}

TEST_F(BadInputTest, Override) {
  ExpectRefused({{"train", kCarMaze, "--set", "learner.gamma=2"}, {"--set learner.gamma=2", "[0, 1]"}});
  ExpectRefused({{"plan", kCarMaze, "--set", "learner.gama=1"}, {"learner.gama", "learner.gamma"}});
}

constexpr const char* kBoxes = "world { kind: BOXES bounds { max { x: 2 y: 1 } } start { max { x: .3 y: .3 } } ";

TEST_F(BadInputTest, GoalInsideAWall) {
  ExpectTrainRefused(std::string(kBoxes) +
                         "goal { min { x: 1.5 y: 0.5 } max { x: 1.6 y: 0.6 } } "
                         "obstacles { min { x: 1.4 y: 0.4 } max { x: 1.7 y: 0.7 } } }",
                     {"world.goal"});
}

TEST_F(BadInputTest, UnreachableGoal) {
  ExpectTrainRefused(std::string(kBoxes) +
                         "goal { min { x: 1.5 y: 0.3 } max { x: 1.9 y: 0.7 } } "
                         "obstacles { min { x: 1 y: 0 } max { x: 1.1 y: 1 } } }",
                     {"world.start"});
}

TEST_F(BadInputTest, EtaTooLarge) {
  ExpectRefused({{"plan", kCarMaze, "--set", "planner.eta=0.3"}, {"planner.eta = 0.3", "largest eta that passes"}});
}

TEST_F(BadInputTest, RunDirectoryTaken) {
  WriteText(directory_ / "summary.json", "{}");
  ExpectRefused({{"train", kCarMaze, "--run-dir", directory_.path()}, {"--run-dir", "already holds a run"}});
}

TEST_F(BadInputTest, Spy) {
  ExpectRefused({{"spy", "--plane", "telemetri"}, {"--plane telemetri", "nearest is telemetry"}});
  ExpectRefused({{"spy"}, {"DISPLAY"}}, 1);
}

TEST_F(BadInputTest, Doctor) {
  ExpectRefused({{"doctor", "/nonexistent"}, {"/nonexistent", "No such file"}});
  ExpectRefused({{"doctor", directory_.path()}, {directory_.path(), "not a run"}});
  ExpectRefused({{"doctor", "--set", "transport.ttl=1"}, {"--set", "experiment file"}});
  ExpectRefused({{"doctor", kCarMaze, "--set", "transport.tll=1"}, {"transport.tll", "ttl"}});
  ExpectRefused({{"doctor", "--lcm-url", "udpm://10.0.0.1:7700"}, {"10.0.0.1", "multicast group"}});
  ExpectRefused({{"doctor", "--key", "k", "--insecure"}, {"--insecure", "--key"}});
  ExpectRefused({{"doctor", "--peer", "--probes", "0"}, {"--probes", "0"}});
}

TEST_F(BadInputTest, HelpAndVersionAreNoErrors) {
  for (const char* word : {"--help", "--version"}) {
    const ProgramResult result = RunProgram({CAIRN_PROGRAM, word});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.out, "");
    EXPECT_EQ(result.err, "");
  }
}

}  // namespace
}  // namespace cairn::deploy
