#include "tests/integration/run_cairn.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "common/core/check.h"
#include "common/core/clock.h"

namespace cairn::testing {
namespace {

// Whether a process ends within `time`.
bool PollEnd(pid_t pid, Duration time) {
  const int fd = static_cast<int>(syscall(SYS_pidfd_open, pid, 0));
  pollfd ended{fd, POLLIN, 0};
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
  const bool end = poll(&ended, 1, static_cast<int>(ms)) > 0;
  close(fd);
  return end;
}

}  // namespace

TemporaryDirectory::TemporaryDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "cairn-test-XXXXXX").string();
  CAIRN_CHECK(mkdtemp(name.data()) != nullptr);
  path_ = name;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Program::Program(const std::string& name, const std::vector<std::string>& arguments, const std::filesystem::path& log,
                 const std::map<std::string, std::string>& environment) {
  const std::string path = (std::filesystem::path(CAIRN_BIN_DIR) / name).string();
  std::vector<std::string> words{path};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_ = fork();
  CAIRN_CHECK(pid_ >= 0);
  if (pid_ > 0) return;
  const int fd = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  dup2(fd, STDOUT_FILENO);
  dup2(fd, STDERR_FILENO);
  for (const auto& [key, value] : environment) setenv(key.c_str(), value.c_str(), 1);
  execv(path.c_str(), argv.data());
  _exit(127);
}

Program::~Program() {
  if (pid_ > 0 && status_ < 0) {
    kill(pid_, SIGKILL);
    Wait();
  }
}

int Program::Wait() {
  if (status_ >= 0) return status_;
  int status = 0;
  waitpid(pid_, &status, 0);
  status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return status_;
}

std::optional<int> Program::WaitFor(Duration time) {
  if (status_ < 0 && !PollEnd(pid_, time)) return std::nullopt;
  return Wait();
}

int RunCairn(const std::vector<std::string>& arguments, const std::filesystem::path& log,
             const std::map<std::string, std::string>& environment) {
  return Program("cairn", arguments, log, environment).Wait();
}

std::vector<std::string> SmallRun(const std::filesystem::path& run_dir, int64_t steps,
                                  const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"train", std::string(CAIRN_SOURCE_DIR) + "/deploy/experiments/car_maze.textproto",
                                     "--run-dir", run_dir.string(), "--quiet"};
  for (const std::string& set : {std::string("vehicle.kind=PLANE_CAR"), "total_env_steps=" + std::to_string(steps),
                                 std::string("learner.learning_starts=500"), std::string("learner.train_freq=10"),
                                 std::string("evaluation.interval_env_steps=1000"),
                                 std::string("evaluation.max_steps=60"), std::string("evaluation.test_starts=20")}) {
    arguments.insert(arguments.end(), {"--set", set});
  }
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

bool WaitUntil(const Program& program, const std::function<bool()>& reached, Duration limit) {
  const TimePoint deadline = Clock::now() + limit;
  while (Clock::now() < deadline) {
    if (reached()) return true;
    if (PollEnd(program.pid(), std::chrono::milliseconds(10))) return false;
  }
  return reached();
}

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

nlohmann::json ReadJson(const std::filesystem::path& path) { return nlohmann::json::parse(ReadFile(path)); }

std::vector<pid_t> Descendants(pid_t pid, const std::string& text) {
  std::map<pid_t, pid_t> parents;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = ReadFile(entry.path() / "stat");
    const size_t end = stat.rfind(')');
    if (end == std::string::npos) continue;
    char state = 0;
    pid_t parent = 0;
    std::istringstream(stat.substr(end + 1)) >> state >> parent;
    if (state != 'Z') parents[std::stoi(name)] = parent;
  }
  std::vector<pid_t> found;
  for (const auto& [child, parent] : parents) {
    pid_t ancestor = parent;
    while (ancestor > 1 && ancestor != pid && parents.contains(ancestor)) ancestor = parents[ancestor];
    const std::string command = ReadFile("/proc/" + std::to_string(child) + "/cmdline");
    if (ancestor == pid && command.find(text) != std::string::npos) found.push_back(child);
  }
  return found;
}

std::vector<std::string> AuditLines(const std::filesystem::path& directory, const std::string& prefix) {
  std::vector<std::string> lines;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    if (entry.path().filename().string().rfind(prefix, 0) != 0) continue;
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) lines.push_back(line);
  }
  return lines;
}

void ExpectReplayMatchesActors(const std::filesystem::path& audit, size_t env_steps, bool actor_died) {
  const std::vector<std::string> replay = AuditLines(audit, "learner");
  const std::vector<std::string> made = AuditLines(audit, "actor");
  const std::set<std::string> replay_set(replay.begin(), replay.end());
  const std::multiset<std::string> made_set(made.begin(), made.end());
  EXPECT_EQ(replay.size(), env_steps);
  EXPECT_EQ(replay_set.size(), replay.size()) << "a transition is in replay twice";
  EXPECT_TRUE(std::includes(made_set.begin(), made_set.end(), replay_set.begin(), replay_set.end()));
  if (!actor_died) {
    EXPECT_EQ(made.size(), replay.size()) << "a transition was lost";
  }
}

}  // namespace cairn::testing
