// A million datagrams that nobody should believe, sent into a live run.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>
#include <functional>

#include "common/core/random.h"
#include "tests/integration/run_cairn.h"

namespace cairn::testing {
namespace {

constexpr int kDatagrams = 1000000;
constexpr std::array<const char*, 8> kChannels{"CAIRN_HELLO",       "CAIRN_STATUS",    "CAIRN_EXP_0000",
                                               "CAIRN_CONTROL",     "CAIRN_POLICY",    "CAIRN_WELCOME",
                                               "CAIRN_TABLE_CHUNK", "CAIRN_TABLE_INFO"};

std::vector<std::string> Arguments(const std::filesystem::path& run_dir) {
  std::vector<std::string> arguments{"train", std::string(CAIRN_SOURCE_DIR) + "/deploy/experiments/car_maze.textproto",
                                     "--run-dir", run_dir.string(), "--quiet"};
  for (const char* set :
       {"vehicle.kind=PLANE_CAR", "total_env_steps=250000", "learner.train_freq=10",
        "evaluation.interval_env_steps=50000", "evaluation.test_starts=20", "lockstep.actor_timeout_s=600"}) {
    arguments.insert(arguments.end(), {"--set", set});
  }
  return arguments;
}

// Random bytes, or an LCM message on one of our channels with random bytes in it, or one without the NUL that ends the
// channel's name. Never LCM's fragments (LC03): those end LCM itself, which SECURITY.md says.
size_t MakeDatagram(RandomStream* random, const std::vector<uint8_t>& noise, uint8_t* bytes) {
  const size_t size = 1 + random->Below(400);
  std::memcpy(bytes, noise.data() + random->Below(static_cast<uint32_t>(noise.size() - size)), size);
  bytes[0] = 0;
  const uint32_t kind = random->Below(4);
  if (kind == 0) return size;
  size_t at = 0;
  const auto put = [&](const void* data, size_t n) {
    std::memcpy(bytes + at, data, n);
    at += n;
  };
  const uint32_t sequence = random->NextU32();
  const char* channel = kChannels[random->Below(kChannels.size())];
  put("LC02", 4);
  put(&sequence, 4);
  put(channel, std::strlen(channel) + (kind == 1 ? 0 : 1));
  return at + (kind == 1 ? 0 : size);
}

// Sends to all planes in turn until everything is out or the run has ended; returns how many went out. `often` is
// called now and then.
int SendGarbage(const std::string& group, int base_port, pid_t run, const std::function<void()>& often) {
  RandomStream random(5, RandomPurpose::kTest);
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  std::array<uint8_t, 2048> bytes{};
  std::vector<uint8_t> noise(1 << 16);
  for (uint8_t& b : noise) b = static_cast<uint8_t>(random.NextU32());
  int sent = 0;
  for (; sent < kDatagrams; ++sent) {
    siginfo_t ended{};
    if (sent % 1024 == 0 && waitid(P_PID, static_cast<id_t>(run), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
        ended.si_pid == run) {
      break;
    }
    if (sent % 1024 == 0) often();
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(base_port + sent % 4));
    inet_pton(AF_INET, group.c_str(), &address.sin_addr);
    const size_t size = MakeDatagram(&random, noise, bytes.data());
    sendto(fd, bytes.data(), size, 0, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
  }
  close(fd);
  return sent;
}

TEST(GarbageTest, AMillionDatagramsChangeNothingButACounter) {
  const TemporaryDirectory directory;
  const std::filesystem::path log = directory.path() / "output.log";
  const std::filesystem::path quiet = directory.path() / "quiet";
  const std::filesystem::path run = directory.path() / "run";
  ASSERT_EQ(RunCairn(Arguments(quiet), log), 0) << ReadFile(log);
  Program train("cairn", Arguments(run), log);
  ASSERT_TRUE(WaitUntil(train, [&] { return std::filesystem::exists(run / "episodes.csv"); })) << ReadFile(log);
  const nlohmann::json info = ReadJson(run / "run.json");
  // A run that is faster than the sender waits for it half-way: its actors stop.
  const auto half = std::filesystem::file_size(quiet / "episodes.csv") / 2;
  std::vector<pid_t> stopped;
  const auto wait_half_way = [&] {
    if (!stopped.empty() || std::filesystem::file_size(run / "episodes.csv") < half) return;
    stopped = Descendants(train.pid(), "cairn-actor");
    for (const pid_t actor : stopped) kill(actor, SIGSTOP);
  };
  EXPECT_EQ(SendGarbage(info["group"], info["base_port"], train.pid(), wait_half_way), kDatagrams)
      << "the run ended too early";
  for (const pid_t actor : stopped) kill(actor, SIGCONT);
  EXPECT_EQ(train.Wait(), 0) << ReadFile(log);
  const nlohmann::json summary = ReadJson(run / "summary.json");
  EXPECT_EQ(summary["weights_crc32c"], ReadJson(quiet / "summary.json")["weights_crc32c"]);
  EXPECT_EQ(summary["transitions_lost"], 0);
  EXPECT_EQ(summary["transitions_duplicate"], 0);
  EXPECT_EQ(summary["deterministic"], true);
  EXPECT_GT(summary["frames_refused"], 1000);
}

}  // namespace
}  // namespace cairn::testing
