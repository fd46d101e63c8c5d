#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "common/core/check.h"
#include "common/core/files.h"
#include "common/core/hash.h"
#include "learner/checkpoint/checkpoint_file.h"
#include "learner/checkpoint/checkpointer.h"
#include "learner/checkpoint/progress_file.h"
#include "learner/checkpoint/run_fields.h"

namespace cairn::learner {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int kObservation = 3;
constexpr int kAction = 2;

class CheckpointTest : public ::testing::Test {
 protected:
  CheckpointTest() {
    std::string name = (fs::temp_directory_path() / "cairn-checkpoint-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp");
    directory_ = name;
  }
  ~CheckpointTest() override { fs::remove_all(directory_); }

  static ReplayBuffer MakeReplay(int capacity) { return {capacity, kObservation, kAction, 1, 0.9}; }

  // Rows whose numbers tell which they are.
  static void Insert(ReplayBuffer* replay, int rows) {
    for (int i = 0; i < rows; ++i) {
      const auto n = static_cast<float>(replay->num_inserted());
      Segment s;
      s.observations = {n, n, n, n + 1, n + 1, n + 1};
      s.actions = {n, n};
      s.rewards = {n};
      replay->Insert(s);
    }
  }

  static void ExpectSameRows(const ReplayBuffer& a, const ReplayBuffer& b) {
    ASSERT_EQ(a.size(), b.size());
    ASSERT_EQ(a.num_inserted(), b.num_inserted());
    for (int64_t n = a.num_inserted() - a.size(); n < a.num_inserted(); ++n) {
      for (int i = 0; i < a.row_floats(); ++i) ASSERT_EQ(a.RowOf(n)[i], b.RowOf(n)[i]) << n;
    }
  }

  static RunState MakeState(int64_t env_steps = 12345) {
    RunState state;
    state.fields = {{"seed", "1"}, {"learner.net_arch", "[4, 4]"}};
    state.git_revision = "abc";
    state.env_steps = env_steps;
    state.updates = 77;
    state.granted = 12999;
    state.transitions_rolled_back = 5;
    state.wall_s = 1.5;
    state.episode_log_bytes = 99;
    state.algorithm = {{"policy", {1, 2, 3, 4}}, {"q1.adam.first", {9}}};
    state.coordinator.rounds = 6;
    state.coordinator.vehicles = {{3, 2, 7, true, -1, 600, {5, 6}, 4}, {1, 0, 0, false, 0, 601, {}}};
    state.coordinator.sessions = {{4, -9, 1000, 17, 55, 610, 700}};
    state.coordinator.granted = {{20, 1, true, {7, 8, {0.5f}}}};
    state.coordinator.counters.eval_steps = 44;
    state.coordinator.counters.disturbed = true;
    state.evaluation.next_check = 20000;
    state.evaluation.consumption_wall_s = 2.5;
    state.evaluation.failed_checks = 2;
    state.evaluation.collapsed = true;
    state.candidates[70] = {{"policy/w", {1, 2, 3}}, {"alpha", {}}};
    state.evaluation.best = PolicySnapshot{70, 10000, {1.0f, -2.0f}};
    state.evaluation.best_success = 0.98;
    state.evaluation.best_time = -6;
    state.evaluation.asked = {{{77, StartSet::kValidation, 50, 12345, 3}, {77, 12345, {4.0f}}}};
    state.replay = {100, 16, {{"replay-x.rows", 0, 100, 0xDEADBEEF}}};
    return state;
  }

  std::string Path(const std::string& name) const { return (directory_ / name).string(); }
  std::vector<std::string> Files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(directory_)) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  fs::path directory_;
};

TEST_F(CheckpointTest, FileRoundTrips) {
  const RunState a = MakeState();
  const RunState b = DecodeCheckpoint(EncodeCheckpoint(a), "x");
  EXPECT_EQ(EncodeCheckpoint(b), EncodeCheckpoint(a)) << "every field survives";
  EXPECT_EQ(b.fields, a.fields);
  EXPECT_EQ(b.granted, 12999);
  ASSERT_EQ(b.algorithm.size(), 2u);
  EXPECT_EQ(b.algorithm[0].data, (Bytes{1, 2, 3, 4}));
  ASSERT_EQ(b.coordinator.vehicles.size(), 2u);
  EXPECT_EQ(b.coordinator.vehicles[0].environment, (Bytes{5, 6}));
  EXPECT_TRUE(b.coordinator.vehicles[0].open);
  ASSERT_EQ(b.coordinator.granted.size(), 1u);
  EXPECT_EQ(b.coordinator.granted[0].policy.parameters, (std::vector<float>{0.5f}));
  EXPECT_TRUE(b.coordinator.counters.disturbed);
  EXPECT_TRUE(b.evaluation.collapsed);
  EXPECT_EQ(b.coordinator.vehicles[0].owner, 4);
  EXPECT_EQ(b.coordinator.vehicles[1].owner, -1);
  ASSERT_EQ(b.coordinator.sessions.size(), 1u);
  EXPECT_EQ(b.coordinator.sessions[0].session, -9);
  EXPECT_EQ(b.coordinator.sessions[0].received, 55);
  EXPECT_EQ(b.coordinator.sessions[0].credit, 700);
  ASSERT_EQ(b.candidates.at(70).size(), 2u);
  EXPECT_EQ(b.candidates.at(70)[0].name, "policy/w");
  EXPECT_EQ(b.candidates.at(70)[0].data, (Bytes{1, 2, 3}));
  EXPECT_EQ(b.evaluation.best->parameters, (std::vector<float>{1.0f, -2.0f}));
  EXPECT_EQ(b.evaluation.asked[0].request.set, StartSet::kValidation);
  EXPECT_EQ(b.replay.chunks[0].crc32c, 0xDEADBEEF);
}

TEST_F(CheckpointTest, EveryFlippedByteAndEveryLengthIsDetected) {
  const std::string whole = EncodeCheckpoint(MakeState());
  for (size_t i = 0; i < whole.size(); ++i) {
    for (const int bit : {0, 3, 7}) {
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      EXPECT_THROW(DecodeCheckpoint(damaged, "x"), Error) << i;
    }
    EXPECT_THROW(DecodeCheckpoint(whole.substr(0, i), "x"), Error) << i;
  }
  EXPECT_THROW(DecodeCheckpoint(whole + "x", "x"), Error);
}

// Two GiB of memory are too much for a test: the limit is asked alone.
TEST_F(CheckpointTest, WhatIsTooLargeToWriteIsAnErrorThatTellsTheLimit) {
  EXPECT_NO_THROW(CheckCheckpointSize(2147483647));
  try {
    CheckCheckpointSize(2147483648);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("a checkpoint of 2147483648 bytes cannot be written: 2147483647 is the most"));
  }
}

TEST_F(CheckpointTest, ErrorsNameTheFileAndTheSection) {
  std::string bytes = EncodeCheckpoint(MakeState());
  const size_t at = bytes.find("q1.adam.first");
  ASSERT_NE(at, std::string::npos);
  bytes[bytes.size() - 5] ^= 1;  // the last byte of the last section
  try {
    DecodeCheckpoint(bytes, "some/file.ckpt");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("some/file.ckpt: section q1.adam.first is damaged"));
  }
}

TEST_F(CheckpointTest, ReplayRowsComeBackWhereverTheRingStands) {
  constexpr int kCapacity = 3 * ReplayChunks::kChunkRows / 2;
  for (const int rows : {1, 100, ReplayChunks::kChunkRows, kCapacity, kCapacity + 1, 3 * kCapacity + 17}) {
    ReplayBuffer replay = MakeReplay(kCapacity);
    Insert(&replay, rows);
    ReplayChunks chunks(directory_.string(), {});
    const ReplayIndex index = chunks.Save(replay, replay.num_inserted());
    ReplayBuffer back = MakeReplay(kCapacity);
    LoadReplay(directory_.string(), index, &back);
    ExpectSameRows(replay, back);
  }
}

TEST_F(CheckpointTest, FullChunksAreWrittenOnce) {
  ReplayBuffer replay = MakeReplay(4 * ReplayChunks::kChunkRows);
  Insert(&replay, ReplayChunks::kChunkRows + 10);
  ReplayChunks chunks(directory_.string(), {});
  const ReplayIndex first = chunks.Save(replay, replay.num_inserted());
  ASSERT_EQ(first.chunks.size(), 2u);
  const std::string full = Path(first.chunks[0].file);
  fs::remove(full);
  Insert(&replay, 10);
  const ReplayIndex second = chunks.Save(replay, replay.num_inserted());
  EXPECT_FALSE(fs::exists(full)) << "known, so not written again";
  EXPECT_EQ(second.chunks[0].file, first.chunks[0].file);
  EXPECT_EQ(second.chunks[1].rows, 20);
  // The next process knows them from the index.
  ReplayChunks later(directory_.string(), second);
  EXPECT_EQ(later.Save(replay, replay.num_inserted()).chunks[1].file, second.chunks[1].file);
}

TEST_F(CheckpointTest, AFullRingKeepsChunksThatItHasPartlyOverwritten) {
  constexpr int kCapacity = 2 * ReplayChunks::kChunkRows;
  ReplayBuffer replay = MakeReplay(kCapacity);
  ReplayChunks chunks(directory_.string(), {});
  for (int i = 0; i < 9; ++i) {
    Insert(&replay, 5000);
    const ReplayIndex index = chunks.Save(replay, replay.num_inserted());
    ReplayBuffer back = MakeReplay(kCapacity);
    LoadReplay(directory_.string(), index, &back);
    ExpectSameRows(replay, back);
  }
}

TEST_F(CheckpointTest, KeepsTheNewestAndRemovesWhatNobodyNeeds) {
  ReplayBuffer replay = MakeReplay(100);
  {
    Checkpointer checkpointer(directory_.string(), 2);
    for (int i = 1; i <= 5; ++i) {
      Insert(&replay, 30);
      checkpointer.Write(MakeState(1000 * i), &replay);
      checkpointer.Wait();
      EXPECT_EQ(checkpointer.status().error, "");
      EXPECT_EQ(checkpointer.status().env_steps, 1000 * i);
    }
    EXPECT_EQ(checkpointer.status().written, 5);
  }
  EXPECT_EQ(ListCheckpoints(directory_.string()),
            (std::vector<std::string>{"checkpoint-000000004000.ckpt", "checkpoint-000000005000.ckpt"}));
  EXPECT_EQ(Files().size(), 4u) << "two checkpoints with their rows";
  std::ofstream(Path("checkpoint-000000006000.ckpt.tmp")) << "half";
  std::ofstream(Path("replay-000000000777-00001.rows")) << "orphan";
  std::ofstream(Path("notes.txt")) << "the user's";
  Checkpointer next(directory_.string(), 2);
  EXPECT_EQ(Files().size(), 5u);
  EXPECT_TRUE(fs::exists(Path("notes.txt")));
  ReplayBuffer back = MakeReplay(100);
  EXPECT_EQ(LoadNewestCheckpoint(directory_.string(), {}, &back).env_steps, 5000);
  ExpectSameRows(replay, back);
}

TEST_F(CheckpointTest, ADamagedNewestOneIsSetAsideAndTheOneBeforeUsed) {
  ReplayBuffer replay = MakeReplay(100);
  {
    Checkpointer checkpointer(directory_.string(), 3);
    for (int i = 1; i <= 3; ++i) {
      Insert(&replay, 10);
      checkpointer.Write(MakeState(1000 * i), &replay);
      checkpointer.Wait();
    }
  }
  // The newest file is damaged, the next one's rows are cut off.
  std::string bytes = ReadFile(Path("checkpoint-000000003000.ckpt"));
  bytes[bytes.size() / 2] ^= 4;
  std::ofstream(Path("checkpoint-000000003000.ckpt"), std::ios::binary) << bytes;
  fs::resize_file(Path("replay-000000000000-00020.rows"), 100);
  ReplayBuffer back = MakeReplay(100);
  EXPECT_EQ(LoadNewestCheckpoint(directory_.string(), {}, &back).env_steps, 1000);
  EXPECT_EQ(back.num_inserted(), 10);
  EXPECT_TRUE(fs::exists(Path("checkpoint-000000003000.ckpt.damaged")));
  fs::remove(Path("replay-000000000000-00010.rows"));
  EXPECT_THROW(LoadNewestCheckpoint(directory_.string(), {}, &back), Error);
  EXPECT_THROW(LoadNewestCheckpoint(directory_.string(), {}, &back), UsageError) << "none left to try";
}

// As with learner.buffer_size edited after the ring has wrapped, or rays taken away.
TEST_F(CheckpointTest, WhatDoesNotFitTheExperimentIsRefusedByNameAndKept) {
  ReplayBuffer replay = MakeReplay(50);
  {
    Checkpointer checkpointer(directory_.string(), 2);
    for (int i = 1; i <= 2; ++i) {
      Insert(&replay, 60);
      checkpointer.Write(MakeState(1000 * i), &replay);
      checkpointer.Wait();
    }
  }
  const std::vector<std::string> files = Files();
  ReplayBuffer larger = MakeReplay(100);
  try {
    LoadNewestCheckpoint(directory_.string(), {{"seed", "2"}}, &larger);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("seed is 1 there, 2 here"));
  }
  ReplayBuffer wider{50, kObservation + 20, kAction, 1, 0.9};
  EXPECT_THROW(LoadNewestCheckpoint(directory_.string(), {{"seed", "1"}}, &wider), UsageError);
  EXPECT_EQ(Files(), files);
  ReplayBuffer back = MakeReplay(50);
  EXPECT_EQ(LoadNewestCheckpoint(directory_.string(), {{"seed", "1"}}, &back).env_steps, 2000);
  ExpectSameRows(replay, back);
}

TEST_F(CheckpointTest, AnotherFormatVersionIsNotDamage) {
  std::string bytes = EncodeCheckpoint(MakeState());
  bytes[8] = 2;
  const uint32_t crc = Crc32c(bytes.data(), bytes.size() - sizeof(uint32_t));
  std::memcpy(bytes.data() + bytes.size() - sizeof(uint32_t), &crc, sizeof(crc));
  EXPECT_THROW(DecodeCheckpoint(bytes, "x"), UsageError);
}

TEST_F(CheckpointTest, AFailureLeavesTheOlderOnesAndIsSaidUntilItWorksAgain) {
  ReplayBuffer replay = MakeReplay(100);
  Insert(&replay, 10);
  Checkpointer checkpointer(directory_.string(), 2);
  checkpointer.Write(MakeState(1000), &replay);
  checkpointer.Wait();
  // A directory where the next file has to go stands in the way, as root minds no permissions.
  fs::create_directory(Path("checkpoint-000000002000.ckpt.tmp"));
  Insert(&replay, 10);
  checkpointer.Write(MakeState(2000), &replay);
  checkpointer.Wait();
  EXPECT_THAT(checkpointer.status().error, HasSubstr("checkpoint-000000002000.ckpt"));
  EXPECT_EQ(checkpointer.status().env_steps, 1000);
  ReplayBuffer back = MakeReplay(100);
  EXPECT_EQ(LoadNewestCheckpoint(directory_.string(), {}, &back).env_steps, 1000);
  Insert(&replay, 200);
  checkpointer.Write(MakeState(3000), &replay);
  checkpointer.Wait();
  EXPECT_EQ(checkpointer.status().error, "");
  EXPECT_EQ(LoadNewestCheckpoint(directory_.string(), {}, &back).env_steps, 3000);
  ExpectSameRows(replay, back);
}

TEST_F(CheckpointTest, RowsThatAreBeingWrittenAreNotOverwritten) {
  ReplayBuffer replay = MakeReplay(50);
  Insert(&replay, 50);
  replay.Protect(0);
  std::jthread writer([&] { replay.Unprotect(); });  // what the writing thread does when the rows are on disk
  Insert(&replay, 1);                                // waits for that
  EXPECT_EQ(replay.num_inserted(), 51);
}

TEST_F(CheckpointTest, AnEmptyDirectoryHasNothingToGoOnFrom) {
  ReplayBuffer replay = MakeReplay(10);
  EXPECT_THROW(LoadNewestCheckpoint(directory_.string(), {}, &replay), UsageError);
  EXPECT_THROW(ReadNewestCheckpoint(directory_.string()), UsageError);
}

TEST_F(CheckpointTest, ProgressSurvivesAndKeepsASecondLearnerOut) {
  {
    ProgressFile progress(Path("progress"));
    EXPECT_EQ(progress.env_steps_before(), 0);
    EXPECT_EQ(progress.incarnation(), 1);
    progress.Write(123456789, 0);
    progress.Write(1200, 34);
    EXPECT_THROW(ProgressFile(Path("progress")), UsageError);
  }
  for (const int64_t incarnation : {2, 3}) {
    ProgressFile progress(Path("progress"));
    EXPECT_EQ(progress.env_steps_before(), 1200);
    EXPECT_EQ(progress.rolled_back_before(), 34);
    EXPECT_EQ(progress.incarnation(), incarnation) << "also when the one before wrote nothing";
  }
}

TEST(RunFieldsTest, DifferencesAreNamedWithBothValues) {
  Experiment here, there;
  EXPECT_NO_THROW(CheckFields(ResumeFields(here), ResumeFields(there), "x"));
  there.learner.net_arch = {32};
  there.seed = 9;
  there.learner.learning_rate = 1;  // may change
  try {
    CheckFields(ResumeFields(here), ResumeFields(there), "runs/a");
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "runs/a: learner.net_arch is [32] there, [64, 64] here; seed is 9 there, 1 here");
  }
}

// The updates of a run are counted from its start.
TEST(RunFieldsTest, UpdatesPerEnvStepMayNotChange) {
  Experiment here, there;
  there.learner.learning_starts = 77;
  there.learner.train_freq = 33;
  there.learner.gradient_steps = 11;
  try {
    CheckFields(ResumeFields(here), ResumeFields(there), "runs/a");
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("learner.learning_starts is 77 there"));
    EXPECT_THAT(error.what(), HasSubstr("learner.train_freq is 33 there"));
    EXPECT_THAT(error.what(), HasSubstr("learner.gradient_steps is 11 there"));
  }
  EXPECT_NO_THROW(CheckFields(NetworkFields(here), NetworkFields(there), "x")) << "init_from counts anew";
}

}  // namespace
}  // namespace cairn::learner
