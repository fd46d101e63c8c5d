// LCM logs: written as LCM writes them, read whatever they hold.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <sstream>

#include "common/bus/log_file.h"
#include "common/bus/log_recorder.h"
#include "common/core/check.h"
#include "common/core/hash.h"
#include "tests/testing/lcm_broker.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;
using testing::LcmBroker;

class LogTest : public ::testing::Test {
 protected:
  LogTest() : directory_(std::filesystem::temp_directory_path() / ("cairn-log-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(directory_);
  }
  ~LogTest() override { std::filesystem::remove_all(directory_); }

  std::string File(const std::string& name) const { return (directory_ / name).string(); }

  // Written by LCM itself.
  std::string WriteLog(const std::vector<LoggedMessage>& messages) const {
    lcm::LogFile log(File("lcm"), "w");
    for (const LoggedMessage& m : messages) {
      Bytes bytes = m.bytes;
      lcm::LogEvent event{0, m.utime, m.channel, static_cast<int32_t>(bytes.size()), bytes.data()};
      EXPECT_EQ(log.writeEvent(&event), 0);
    }
    return File("lcm");
  }

  std::string Content(const std::string& file) const {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

  std::string WriteRaw(const std::string& content) const {
    std::ofstream(File("raw"), std::ios::binary) << content;
    return File("raw");
  }

  static std::vector<LoggedMessage> ReadAll(LogReader* reader) {
    std::vector<LoggedMessage> all;
    while (std::optional<LoggedMessage> m = reader->Next()) all.push_back(std::move(*m));
    return all;
  }

  const std::filesystem::path directory_;
  const std::vector<LoggedMessage> messages_{
      {1000, "CAIRN_EXP_0000", Bytes(100, 7)}, {2000, "X", Bytes{}}, {3000, "CAIRN_HELLO", Bytes(3, 0xED)}};
};

void ExpectSame(const std::vector<LoggedMessage>& a, const std::vector<LoggedMessage>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].utime, b[i].utime);
    EXPECT_EQ(a[i].channel, b[i].channel);
    EXPECT_EQ(a[i].bytes, b[i].bytes);
  }
}

TEST_F(LogTest, ReadsWhatLcmWrites) {
  LogReader reader(WriteLog(messages_));
  ExpectSame(ReadAll(&reader), messages_);
  EXPECT_EQ(reader.faults(), 0);
}

TEST_F(LogTest, TornAnywhereGivesTheWholeMessagesAndOneFault) {
  const std::string whole = Content(WriteLog(messages_));
  const std::vector<size_t> ends{0, 28 + 14 + 100, 28 + 14 + 100 + 29, whole.size()};
  for (size_t size = 0; size <= whole.size(); ++size) {
    LogReader reader(WriteRaw(whole.substr(0, size)));
    const auto end = std::upper_bound(ends.begin(), ends.end(), size) - 1;
    EXPECT_EQ(ReadAll(&reader).size(), static_cast<size_t>(end - ends.begin())) << size;
    EXPECT_EQ(reader.faults(), *end == size ? 0 : 1) << size;
  }
}

TEST_F(LogTest, GarbageAndCraftedLengthsAreSkippedAndCounted) {
  const std::string whole = Content(WriteLog(messages_));
  std::string crafted = whole.substr(0, 28);
  crafted.replace(24, 4, "\x7f\xff\xff\xff");  // LCM's own reader crashes at this one
  LogReader reader(WriteRaw(crafted + "rubbish" + whole + "\xED\xA1" + whole));
  EXPECT_EQ(ReadAll(&reader).size(), 5u);  // what stands before garbage may be cut by it, and is not believed
  EXPECT_EQ(reader.faults(), 2);
  LogReader nothing(WriteRaw(std::string(100000, '\xED')));
  EXPECT_TRUE(ReadAll(&nothing).empty());
  EXPECT_EQ(nothing.faults(), 1);
  EXPECT_THROW(LogReader(File("absent")), UsageError);
  EXPECT_THROW(LogReader(directory_.string()), UsageError);
}

BusConfig Config(int block) {
  BusConfig config;
  config.base_port = 22600 + 10 * block;
  config.run_id = 42;
  config.session = RandomId();
  return config;
}

// Messages of a channel that a log which is still being written holds whole.
int CountOn(const std::string& channel, const std::string& file) {
  LogReader reader(file);
  int count = 0;
  while (const std::optional<LoggedMessage> m = reader.Next()) count += m->channel == channel;
  return count;
}

// 300 messages of 8 kB and 60 kB on the experience plane, 300 on the control plane, some on one that nobody asked for.
std::vector<LoggedMessage> Record(const BusConfig& config, const std::string& file) {
  LogRecorder recorder({config, {Plane::kExperience, Plane::kControl}, file});
  Bus bus(config);
  const auto count = [&](Plane plane) { return recorder.stats().messages[static_cast<size_t>(plane)]; };
  const TimePoint deadline = Clock::now() + seconds(20);
  // Over a broker a subscription takes its time.
  while (count(Plane::kExperience) == 0 || count(Plane::kControl) == 0) {
    bus.Publish(Plane::kExperience, kHelloChannel, Hello{});
    bus.Publish(Plane::kControl, kControlChannel, Control{});
    bus.Poll(milliseconds(20));
    if (Clock::now() > deadline) break;
  }
  for (int i = 0; i < 300; ++i) {
    const int bytes = i % 10 == 0 ? 59000 : 8000;
    bus.Publish(Plane::kExperience, ExperienceChannel(3),
                TableChunk{1, bytes * 300, i, bytes, Bytes(static_cast<size_t>(bytes), static_cast<uint8_t>(i))});
    bus.Publish(Plane::kControl, kPolicyChannel, TableChunk{2, 300, i, 1, Bytes(1, 1)});
    bus.Publish(Plane::kTelemetry, kLearnerChannel, LearnerTelemetry{});
    const int64_t so_far = i;
    while ((count(Plane::kExperience) <= so_far || count(Plane::kControl) <= so_far) && Clock::now() < deadline) {
      bus.Poll(milliseconds(1));
    }
  }
  // A broker may still have the last ones when the counts, which the greetings are part of, are reached.
  while ((CountOn(ExperienceChannel(3), file) < 300 || CountOn(kPolicyChannel, file) < 300) &&
         Clock::now() < deadline) {
    bus.Poll(milliseconds(20));
  }
  const RecordingStats stats = recorder.Finish();
  EXPECT_EQ(stats.dropped(), 0);
  EXPECT_EQ(stats.error, "");
  LogReader reader(file);
  std::vector<LoggedMessage> all;
  while (std::optional<LoggedMessage> m = reader.Next()) all.push_back(std::move(*m));
  EXPECT_EQ(reader.faults(), 0);
  EXPECT_EQ(static_cast<int64_t>(all.size()), stats.messages[0] + stats.messages[1]);
  return all;
}

void ExpectRecorded(const std::vector<LoggedMessage>& log) {
  int experience = 0, control = 0;
  for (const LoggedMessage& m : log) {
    EXPECT_NE(m.channel, kLearnerChannel);
    if (m.channel != ExperienceChannel(3) && m.channel != kPolicyChannel) continue;
    const OpenedFrame opened = FrameSeal(42).Open(Plane::kExperience, ByteSpan(m.bytes));
    ASSERT_FALSE(opened.fault);
    const auto chunk = Decode<TableChunk>(opened.message);
    ASSERT_TRUE(chunk);
    EXPECT_EQ(chunk->chunk, m.channel == kPolicyChannel ? control++ : experience++);
  }
  EXPECT_EQ(experience, 300);
  EXPECT_EQ(control, 300);
}

TEST_F(LogTest, RecordsChosenPlanesOfMulticastWholeAndInOrder) { ExpectRecorded(Record(Config(0), File("out"))); }

TEST_F(LogTest, RecordsChosenPlanesOfABrokerWholeAndInOrder) {
  if (!LcmBroker::Missing().empty()) GTEST_SKIP() << LcmBroker::Missing();
  const LcmBroker broker(22690);
  BusConfig config = Config(1);
  config.broker = broker.address();
  ExpectRecorded(Record(config, File("out")));
}

TEST_F(LogTest, FullDiskIsAnErrorThatNamesTheFile) {
  LogRecorder recorder({Config(2), {Plane::kExperience}, "/dev/full"});
  Bus bus(Config(2));
  const TimePoint deadline = Clock::now() + seconds(20);
  while (recorder.stats().error.empty() && Clock::now() < deadline) {
    bus.Publish(Plane::kExperience, kHelloChannel, Hello{});
    bus.Poll(milliseconds(5));
  }
  EXPECT_EQ(recorder.Finish().error, "log /dev/full: No space left on device");
  EXPECT_THROW(LogRecorder({Config(2), {Plane::kExperience}, "/no/such/folder/file"}), Error);
}

}  // namespace
}  // namespace cairn
