#include "deploy/launcher/run_directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/core/check.h"
#include "tests/deploy/launcher/test_support.h"

namespace cairn::deploy {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RunDirectoryTest : public testing::Test {
 protected:
  TemporaryDirectory directory_;
};

TEST_F(RunDirectoryTest, CreatesParentsAndHoldsTheExperiment) {
  const RunDirectory run = RunDirectory::Create(directory_ / "a/b/run", "car", "seed: 1\n");
  EXPECT_EQ(ReadText(run.experiment_file()), "seed: 1\n");
  EXPECT_TRUE(fs::is_directory(run.path() + "/log"));
  EXPECT_TRUE(fs::is_directory(run.path() + "/checkpoints"));
  EXPECT_EQ(run.policy_file("best"), run.path() + "/checkpoints/best.policy");
  EXPECT_EQ(RunDirectory::Open(directory_ / "a/b/run").path(), run.path());
}

TEST_F(RunDirectoryTest, DefaultNameTellsExperimentAndDate) {
  const fs::path before = fs::current_path();
  fs::current_path(directory_.path());
  const RunDirectory first = RunDirectory::Create("", "car", "");
  const RunDirectory second = RunDirectory::Create("", "car", "");
  fs::current_path(before);
  EXPECT_THAT(first.path(), testing::ContainsRegex("/runs/car-[0-9]{8}-[0-9]{6}$"));
  EXPECT_NE(first.path(), second.path());
}

TEST_F(RunDirectoryTest, RunIsNeverOverwritten) {
  RunDirectory::Create(directory_ / "run", "car", "seed: 1\n");
  try {
    RunDirectory::Create(directory_ / "run", "car", "seed: 2\n");
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("it already holds a run"));
  }
  EXPECT_EQ(ReadText(directory_ / "run/experiment.textproto"), "seed: 1\n");
}

// A run that was stopped or refused before its first checkpoint does not bar its own command.
TEST_F(RunDirectoryTest, WhatEndedBeforeItsFirstCheckpointGoesAside) {
  RunInfo info;
  info.pid = 1 << 30;  // nobody
  WriteRunInfo(RunDirectory::Create(directory_ / "run", "car", "seed: 1\n"), info);
  WriteText(directory_ / "run/notes", "mine");
  RunDirectory::CheckVacant(directory_ / "run");
  const RunDirectory run = RunDirectory::Create(directory_ / "run", "car", "seed: 2\n");
  EXPECT_EQ(ReadText(run.experiment_file()), "seed: 2\n");
  EXPECT_EQ(ReadText(directory_ / "run/void-1/experiment.textproto"), "seed: 1\n");
  EXPECT_EQ(ReadText(directory_ / "run/notes"), "mine");
  WriteRunInfo(run, info);
  WriteText(run.path() + "/checkpoints/checkpoint-1.ckpt", "");
  EXPECT_THROW(RunDirectory::Create(directory_ / "run", "car", ""), UsageError);
}

TEST_F(RunDirectoryTest, AMapIsCopiedOrNothingIsLeft) {
  const std::string map = directory_ / "floor.map";
  WriteText(map, "type octile\nheight 1\nwidth 1\nmap\n.\n");
  const RunDirectory run = RunDirectory::Create(directory_ / "run", "floor", "seed: 1\n", map);
  EXPECT_EQ(ReadText(run.map_folder() + "/floor.map"), ReadText(map));
  EXPECT_THROW(RunDirectory::Create(directory_ / "other", "floor", "seed: 1\n", directory_ / "none.map"), UsageError);
  EXPECT_FALSE(fs::exists(directory_ / "other"));
}

TEST_F(RunDirectoryTest, ARoadmapIsCopiedOrNothingIsLeft) {
  WriteText(directory_ / "a.roadmap", "bytes");
  const RunDirectory run = RunDirectory::Create(directory_ / "run", "x", "name: \"x\"\n", "", directory_ / "a.roadmap");
  EXPECT_EQ(ReadText(run.roadmap_folder() + "/a.roadmap"), "bytes");
  EXPECT_ANY_THROW(RunDirectory::Create(directory_ / "other", "x", "", "", directory_ / "none.roadmap"));
  EXPECT_FALSE(std::filesystem::exists(directory_ / "other"));
}

TEST_F(RunDirectoryTest, OtherFilesAreLeftAlone) {
  fs::create_directory(directory_ / "run");
  WriteText(directory_ / "run/roadmap.svg", "<svg/>");
  RunDirectory::Create(directory_ / "run", "car", "seed: 1\n");
  EXPECT_EQ(ReadText(directory_ / "run/roadmap.svg"), "<svg/>");
}

TEST_F(RunDirectoryTest, FileInTheWayIsAnError) {
  WriteText(directory_ / "file", "");
  EXPECT_THROW(RunDirectory::Create(directory_ / "file", "car", ""), Error);
  EXPECT_THROW(RunDirectory::Create(directory_ / "file/run", "car", ""), Error);
}

TEST_F(RunDirectoryTest, OpenNamesWhatIsMissing) {
  EXPECT_THROW(RunDirectory::Open(directory_ / "none"), UsageError);
  EXPECT_THROW(RunDirectory::Open(directory_.path()), UsageError);
}

TEST_F(RunDirectoryTest, InfoReadsBack) {
  const RunDirectory run = RunDirectory::Create(directory_ / "run", "car", "");
  RunInfo info;
  info.pid = 4711;
  info.run_id = 0x7123456789abcdef;
  info.bus = {"239.1.2.3", 7705, 1, info.run_id, 5};
  info.network = {true, true, 4026531840};
  info.actors = 3;
  WriteRunInfo(run, info);
  const RunInfo read = ReadRunInfo(run);
  EXPECT_EQ(read.pid, 4711);
  EXPECT_EQ(read.run_id, info.run_id);
  EXPECT_EQ(read.bus.group, "239.1.2.3");
  EXPECT_EQ(read.bus.base_port, 7705);
  EXPECT_EQ(read.bus.ttl, 1);
  EXPECT_EQ(read.bus.run_id, info.run_id);
  EXPECT_TRUE(read.network.is_private && read.network.user_namespace);
  EXPECT_EQ(read.network.inode, 4026531840u);
  EXPECT_EQ(read.actors, 3);
}

TEST_F(RunDirectoryTest, InfoTellsOtherHostsHowToJoinButNotTheKey) {
  const RunDirectory run = RunDirectory::Create(directory_ / "run", "car", "");
  RunInfo info;
  info.run_id = 0x5eed;
  info.bus = {"239.1.2.3", 7705, 1, info.run_id, 5, CreateKeyFile(run.key_file())};
  WriteRunInfo(run, info);
  const std::string text = ReadText(run.info_file());
  EXPECT_THAT(text, HasSubstr("cairn actor experiment.textproto --lcm-url 'udpm://239.1.2.3:7705?ttl=1' --run-id 5eed "
                              "--key key --actor-id N"));
  EXPECT_THAT(text, HasSubstr(run.key_file()));
  EXPECT_THAT(text, testing::Not(HasSubstr(ReadText(run.key_file()).substr(0, 64))));
  info.bus.key.reset();
  WriteRunInfo(run, info);
  EXPECT_THAT(ReadText(run.info_file()), HasSubstr("--run-id 5eed --insecure --actor-id N"));
  info.bus.ttl = 0;
  WriteRunInfo(run, info);
  EXPECT_THAT(ReadText(run.info_file()), testing::Not(HasSubstr("cairn actor")));
}

TEST_F(RunDirectoryTest, BrokenInfoIsNamed) {
  const RunDirectory run = RunDirectory::Create(directory_ / "run", "car", "");
  EXPECT_THROW(ReadRunInfo(run), UsageError);
  for (const char* text : {"", "{", "[]", "{\"pid\": \"x\"}"}) {
    WriteText(run.info_file(), text);
    try {
      ReadRunInfo(run);
      FAIL() << text;
    } catch (const UsageError& error) {
      EXPECT_THAT(error.what(), HasSubstr("run.json"));
    }
  }
}

// A file system of 64 kB, filled to the last byte, in namespaces of our own.
TEST_F(RunDirectoryTest, FullDiskIsOneClearErrorAndLeavesNothing) {
  const int result = InChildProcess([this] {
    if (unshare(CLONE_NEWNS) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return kNotAllowed;
    if (mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return kNotAllowed;
    if (mount("tmpfs", directory_.path().c_str(), "tmpfs", 0, "size=64k") != 0) return kNotAllowed;
    std::ofstream filler(directory_ / "filler", std::ios::binary);
    for (int i = 0; i < 1000 && filler; ++i) filler << std::string(4096, 'x') << std::flush;
    try {
      RunDirectory::Create(directory_ / "run", "car", "seed: 1\n");
    } catch (const Error& error) {
      const std::string text = error.what();
      const bool clear = text.find("experiment.textproto") != std::string::npos &&
                         text.find("No space left on device") != std::string::npos;
      if (!clear) fprintf(stderr, "%s\n", text.c_str());
      return clear && !fs::exists(directory_ / "run") ? 0 : 1;
    }
    return 2;
  });
  if (result == kNotAllowed) GTEST_SKIP() << "this kernel or container refuses to mount a file system";
  EXPECT_EQ(result, 0);
}

}  // namespace
}  // namespace cairn::deploy
