#include "learner/metrics/event_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/core/check.h"
#include "common/core/hash.h"

namespace cairn::learner {
namespace {

std::string ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

template <typename T>
T LittleEndian(const std::string& bytes, size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

uint32_t MaskedCrc(const std::string& bytes) {
  const uint32_t crc = Crc32c(bytes.data(), bytes.size());
  return ((crc >> 15) | (crc << 17)) + 0xA282EAD8u;
}

/// Payloads of a TFRecord file; every CRC is checked.
std::vector<std::string> Records(const std::string& bytes) {
  std::vector<std::string> records;
  size_t at = 0;
  while (at + 12 <= bytes.size()) {
    const auto length = LittleEndian<uint64_t>(bytes, at);
    EXPECT_EQ(LittleEndian<uint32_t>(bytes, at + 8), MaskedCrc(bytes.substr(at, 8)));
    records.push_back(bytes.substr(at + 12, length));
    EXPECT_EQ(LittleEndian<uint32_t>(bytes, at + 12 + length), MaskedCrc(records.back()));
    at += 16 + length;
  }
  EXPECT_EQ(at, bytes.size()) << "torn record";
  return records;
}

/// A scalar event as TensorBoard reads it, decoded by hand from protobuf's wire format.
struct Point {
  double wall_time = 0;
  int64_t step = 0;
  std::string file_version, tag;
  float value = 0;
};

void Decode(const std::string& bytes, const std::string& path, Point* point) {
  for (size_t at = 0; at < bytes.size();) {
    const int key = static_cast<unsigned char>(bytes[at++]);
    const std::string field = path + "/" + std::to_string(key >> 3);
    switch (key & 7) {
      case 0: {
        int64_t value = 0;
        for (int shift = 0;; shift += 7) {
          const auto byte = static_cast<unsigned char>(bytes[at++]);
          value |= static_cast<int64_t>(byte & 0x7F) << shift;
          if (byte < 0x80) break;
        }
        if (field == "/2") point->step = value;
        break;
      }
      case 1:
        if (field == "/1") point->wall_time = LittleEndian<double>(bytes, at);
        at += 8;
        break;
      case 5:
        if (field == "/5/1/2") point->value = LittleEndian<float>(bytes, at);
        at += 4;
        break;
      case 2: {
        const size_t size = static_cast<unsigned char>(bytes[at++]);
        ASSERT_LT(size, 128u);
        const std::string inner = bytes.substr(at, size);
        if (field == "/3") point->file_version = inner;
        if (field == "/5/1/1") point->tag = inner;
        if (field == "/5" || field == "/5/1") Decode(inner, field, point);
        at += size;
        break;
      }
      default:
        FAIL() << "wire type " << (key & 7);
    }
  }
}

Point Decode(const std::string& record) {
  Point point;
  Decode(record, "", &point);
  return point;
}

class EventWriterTest : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = testing::TempDir() + "events_" + testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  std::string directory_;
};

TEST_F(EventWriterTest, WritesWhatTensorBoardReads) {
  EventWriter writer(directory_);
  EXPECT_THAT(std::filesystem::path(writer.path()).filename().string(), testing::StartsWith("events.out.tfevents."));
  writer.Scalar("train/critic_loss", 0.25, 20000, 1234.5);
  writer.Scalar("rollout/success_rate", -1.0, 5000000000, 1235.5);
  writer.Flush();
  const std::vector<std::string> records = Records(ReadBytes(writer.path()));
  ASSERT_EQ(records.size(), 3u);
  EXPECT_EQ(Decode(records[0]).file_version, "brain.Event:2");
  const Point first = Decode(records[1]), second = Decode(records[2]);
  EXPECT_EQ(first.tag, "train/critic_loss");
  EXPECT_EQ(first.value, 0.25f);
  EXPECT_EQ(first.step, 20000);
  EXPECT_EQ(first.wall_time, 1234.5);
  EXPECT_EQ(second.tag, "rollout/success_rate");
  EXPECT_EQ(second.value, -1.0f);
  EXPECT_EQ(second.step, 5000000000);
}

TEST_F(EventWriterTest, WritesTheRestWhenItEnds) {
  std::string path;
  {
    EventWriter writer(directory_);
    path = writer.path();
    writer.Scalar("a", 1.0, 1);
  }
  EXPECT_EQ(Records(ReadBytes(path)).size(), 2u);
}

TEST_F(EventWriterTest, NamesADirectoryThatIsNotThere) {
  try {
    EventWriter writer(directory_ + "/missing");
    FAIL() << "created";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("missing/events.out"), testing::HasSubstr("No such")));
  }
}

TEST(LogFileTest, FullDiskIsNamed) {
  LogFile file("/dev/full", true);
  file.Append("record\n");
  try {
    file.Flush();
    FAIL() << "written";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                testing::AllOf(testing::HasSubstr("/dev/full"), testing::HasSubstr("No space left on device")));
  }
}

// A limit on the file's size stands for a disk that fills up in the middle of a record and is then freed.
TEST(LogFileTest, LeavesNoTornRecordWhenSpaceReturns) {
  const std::string path = testing::TempDir() + "log_file_torn";
  rlimit old_limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  {
    LogFile file(path);
    file.Append("0123456789\n");
    file.Flush();
    rlimit limit = old_limit;
    limit.rlim_cur = 16;
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    file.Append("abcdefghij\n");
    EXPECT_THROW(file.Flush(), Error);
    EXPECT_THROW(file.Flush(), Error);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old_limit), 0);
    file.Append("ABCDEFGHIJ\n");
    file.Flush();
  }
  std::signal(SIGXFSZ, old_handler);
  EXPECT_EQ(ReadBytes(path), "0123456789\nabcdefghij\nABCDEFGHIJ\n");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace cairn::learner
