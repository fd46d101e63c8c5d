#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include "common/core/check.h"
#include "common/nn/policy.h"

namespace cairn {
namespace {

using testing::HasSubstr;

PolicyFile SmallPolicy() {
  PolicyFile policy;
  policy.shape.head = PolicyShape::Head::kDeterministic;
  policy.shape.observation_size = 3;
  policy.shape.action_size = 1;
  policy.shape.net_arch = {4};
  policy.shape.layer_norm = true;
  for (size_t i = 0; i < policy.shape.num_parameters(); ++i) policy.parameters.push_back(0.25f * static_cast<float>(i));
  policy.version = 12;
  policy.env_steps = 345678;
  policy.experiment_hash = 0x123456789ABCDEF0ull;
  return policy;
}

std::string ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

void WriteBytes(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

class PolicyFileTest : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = testing::TempDir() + "policy_file_" + testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(directory_);
    path_ = directory_ + "/policy.pb";
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  std::string directory_, path_;
};

TEST_F(PolicyFileTest, RoundTrips) {
  const PolicyFile saved = SmallPolicy();
  SavePolicy(saved, path_);
  const PolicyFile loaded = LoadPolicy(path_);
  EXPECT_EQ(loaded.shape, saved.shape);
  EXPECT_EQ(loaded.parameters, saved.parameters);
  EXPECT_EQ(loaded.version, saved.version);
  EXPECT_EQ(loaded.env_steps, saved.env_steps);
  EXPECT_EQ(loaded.experiment_hash, saved.experiment_hash);
}

TEST_F(PolicyFileTest, ReplacesAndLeavesNothingBeside) {
  PolicyFile policy = SmallPolicy();
  SavePolicy(policy, path_);
  policy.version = 13;
  SavePolicy(policy, path_);
  EXPECT_EQ(LoadPolicy(path_).version, 13);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(directory_), {}), 1);
}

TEST_F(PolicyFileTest, DetectsEveryTruncation) {
  SavePolicy(SmallPolicy(), path_);
  const std::string bytes = ReadBytes(path_);
  for (size_t size = 0; size < bytes.size(); ++size) {
    WriteBytes(path_, bytes.substr(0, size));
    EXPECT_THROW(LoadPolicy(path_), Error) << size << " bytes";
  }
}

TEST_F(PolicyFileTest, DetectsEveryFlippedBit) {
  SavePolicy(SmallPolicy(), path_);
  const std::string bytes = ReadBytes(path_);
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string damaged = bytes;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    WriteBytes(path_, damaged);
    EXPECT_THROW(LoadPolicy(path_), Error) << "bit " << bit;
  }
}

TEST_F(PolicyFileTest, NamesPathAndReason) {
  EXPECT_THAT(MessageOf([&] { LoadPolicy(path_); }), testing::AllOf(HasSubstr(path_), HasSubstr("No such file")));
  SavePolicy(SmallPolicy(), path_);
  std::string bytes = ReadBytes(path_);
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  WriteBytes(path_, bytes);
  EXPECT_THAT(MessageOf([&] { LoadPolicy(path_); }), testing::AllOf(HasSubstr(path_), HasSubstr("CRC32C")));
  bytes[1] = 9;  // the format version's value
  WriteBytes(path_, bytes);
  EXPECT_THAT(MessageOf([&] { LoadPolicy(path_); }), testing::AllOf(HasSubstr(path_), HasSubstr("format version 9")));
  const std::string missing = directory_ + "/missing/policy.pb";
  EXPECT_THAT(MessageOf([&] { SavePolicy(SmallPolicy(), missing); }),
              testing::AllOf(HasSubstr(missing), HasSubstr("No such file")));
}

TEST_F(PolicyFileTest, FullDiskIsNamedAndKeepsTheOldFile) {
  // /dev/full accepts the open and refuses every write with ENOSPC; the writer's file beside is a link to it.
  SavePolicy(SmallPolicy(), path_);
  std::filesystem::create_symlink("/dev/full", path_ + ".tmp");
  PolicyFile next = SmallPolicy();
  next.version = 99;
  EXPECT_THAT(MessageOf([&] { SavePolicy(next, path_); }),
              testing::AllOf(HasSubstr(path_), HasSubstr("No space left on device")));
  EXPECT_EQ(LoadPolicy(path_).version, SmallPolicy().version);
}

}  // namespace
}  // namespace cairn
